// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/mesh_panel.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QScrollArea>
#include <QVBoxLayout>
#include <algorithm>

#include "gui/input/key_map.h"
#include "gui/look/number_box.h"
#include "gui/look/widgets.h"
#include "gui/panels/mesh_card.h"
#include "gui/workbench/frame_loop.h"
#include "gui/workbench/run_state.h"
#include "gui/workbench/workbench.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {

MeshPanel::MeshPanel(Workbench& workbench, FrameLoop& loop, ActionTable& actions, QWidget* parent)
    : QWidget(parent), workbench_(workbench), loop_(loop), actions_(actions) {
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(8, 6, 8, 6);
  layout->setSpacing(6);
  auto* title = new QLabel(tr("<b>Segmentations</b>"), this);
  layout->addWidget(title);
  build_list();
  build_adding();
  connect(&workbench_, &Workbench::scene_changed, this, &MeshPanel::refresh);
  connect(&workbench_, &Workbench::running_changed, this, &MeshPanel::refresh_states);
  // Values that change with every frame are unreadable, so the states are refreshed three times a second.
  states_.setSingleShot(true);
  states_.setInterval(300);
  connect(&states_, &QTimer::timeout, this, &MeshPanel::refresh_states);
  connect(&loop_, &FrameLoop::ticked, this, [this] {
    if (!states_.isActive() && !workbench_.is_dragging()) states_.start();
  });
  for (const auto signal : {&Workbench::pose_changed, &Workbench::solving_changed})
    connect(&workbench_, signal, this, [this] {
      if (!states_.isActive()) states_.start();
    });
  connect(&workbench_, &Workbench::volume_changed, this, [this] {
    if (!workbench_.has_volume()) return;
    const VolumeGeometry& geometry = workbench_.session().volume().geometry();
    const Eigen::Vector3d extent = world_box(geometry).extent_mm();
    const double least_mm = std::min(0.1, 0.5 * geometry.spacing_mm.minCoeff());
    radius_->setDecimals(position_decimals(geometry));
    radius_->setRange(least_mm, std::max(500.0, extent.maxCoeff()));
    radius_->setValue(std::max(least_mm, 0.1 * extent.minCoeff()));
  });
  refresh();
}

void MeshPanel::build_list() {
  auto* scroll = new QScrollArea(this);
  scroll->setWidgetResizable(true);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  scroll->setMinimumHeight(60);
  list_ = new QWidget(scroll);
  column_ = new QVBoxLayout(list_);
  column_->setContentsMargins(0, 0, 4, 0);
  column_->setSpacing(4);
  empty_ = new QLabel(list_);
  const auto show_keys = [this] {
    empty_->setText(
        tr("None yet: choose the tool New segmentation (%1) and drag in a slice from the centre of a structure "
           "to its edge.")
            .arg(key_hint(Act::ToolSeed)));
  };
  show_keys();
  connect(&KeyMap::shared(), &KeyMap::changed, this, show_keys);
  empty_->setWordWrap(true);
  set_role(empty_, "dim");
  column_->addWidget(empty_);
  gap_ = new QFrame(list_);
  gap_->setObjectName("gap");
  gap_->setFixedHeight(2);
  gap_->hide();
  column_->addStretch(1);
  scroll->setWidget(list_);
  static_cast<QVBoxLayout*>(layout())->addWidget(scroll, 1);
}

void MeshPanel::build_adding() {
  auto* adding = new QHBoxLayout;
  add_ = new QPushButton(tr("Add seed at crosshair"), this);
  add_->setToolTip(tr("Add a segmentation that starts as a sphere at the crosshair"));
  radius_ = new NumberBox(this);
  radius_->setRange(0.1, 500);
  radius_->setDecimals(1);
  radius_->setValue(20);
  radius_->setSuffix(tr(" mm"));
  radius_->setPrefix(tr("r "));
  radius_->setToolTip(tr("Radius of the sphere of a new seed"));
  radius_->setAccessibleName(tr("Radius of a new seed"));
  adding->addWidget(add_, 1);
  adding->addWidget(radius_);
  static_cast<QVBoxLayout*>(layout())->addLayout(adding);
  connect(add_, &QPushButton::clicked, this, &MeshPanel::add_at_crosshair);
}

void MeshPanel::refresh() {
  const std::vector<MeshItem>& meshes = workbench_.scene().meshes;
  while (cards_.size() > meshes.size()) {
    cards_.back()->hide();
    cards_.back()->deleteLater();  // not at once, because the mesh may have been deleted from the menu of this card
    cards_.pop_back();
  }
  while (cards_.size() < meshes.size()) {
    auto* card = new MeshCard(workbench_, actions_, list_);
    cards_.push_back(card);
    connect(card, &MeshCard::dragged, this, [this](const QPoint& at) { show_gap(gap_at(at)); });
    connect(card, &MeshCard::dropped, this, [this, card](const QPoint& at) { drop(*card, gap_at(at)); });
    column_->insertWidget(static_cast<int>(cards_.size()), cards_.back());
  }
  for (std::size_t m = 0; m < meshes.size(); ++m)
    cards_[m]->show_mesh(meshes[m], meshes[m].id == workbench_.view.active_mesh);
  empty_->setVisible(meshes.empty());
  const QString no_volume = tr("Open a volume first");
  set_enabled(add_, workbench_.has_volume(), no_volume);
  set_enabled(radius_, workbench_.has_volume(), no_volume);
  refresh_states();
}

void MeshPanel::refresh_states() {
  // Poses are read back only while nothing moves, so that the simulation never waits for this display.
  const bool moves = is_moving(workbench_, loop_);
  const std::vector<MeshItem>& meshes = moves ? workbench_.scene().meshes : workbench_.session().scene().meshes;
  for (std::size_t m = 0; m < meshes.size() && m < cards_.size(); ++m) {
    const RunState state = mesh_state(workbench_, loop_, m);
    cards_[m]->show_state(text_of(state, workbench_.solving_percent()), is_warning(state), advice_of(workbench_, m));
    cards_[m]->show_prior(meshes[m]);
    cards_[m]->show_update(workbench_.session().solving_mesh() == meshes[m].id, state == RunState::Pending);
    const bool known = !moves || meshes[m].locked;
    if (!meshes[m].mesh.positions.empty())
      cards_[m]->show_volume(known ? std::optional(measure(meshes[m].mesh).volume_mm3) : std::nullopt);
  }
}

int MeshPanel::gap_at(const QPoint& on_screen) const {
  const int y = list_->mapFromGlobal(on_screen).y();
  return static_cast<int>(std::count_if(cards_.begin(), cards_.end(),
                                        [y](const MeshCard* card) { return card->geometry().center().y() < y; }));
}

void MeshPanel::show_gap(int gap) {
  const std::size_t after = static_cast<std::size_t>(gap);
  const int y = after < cards_.size() ? cards_[after]->y() - 3 : cards_.back()->geometry().bottom() + 2;
  gap_->setGeometry(0, y, list_->width(), 2);
  gap_->show();
  gap_->raise();
}

void MeshPanel::drop(MeshCard& card, int gap) {
  gap_->hide();
  const auto from = static_cast<int>(std::find(cards_.begin(), cards_.end(), &card) - cards_.begin());
  const int place = gap > from ? gap - 1 : gap;
  if (place != from) workbench_.apply(ReorderMesh{card.mesh(), place});
}

void MeshPanel::add_at_crosshair() {
  const Seed seed{workbench_.view.crosshair_mm, radius_->value()};
  if (workbench_.apply(AddMesh{{}, seed, std::nullopt, workbench_.view.active_mesh})) emit workbench_.mesh_placed();
}

}  // namespace simplexseg
