// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/mesh_panel.h"

#include <QAction>
#include <QColorDialog>
#include <QDoubleSpinBox>
#include <QGridLayout>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QLocale>
#include <QPushButton>
#include <QSignalBlocker>
#include <QTreeWidget>
#include <QVBoxLayout>

#include "gui/input/action_table.h"
#include "gui/look/widgets.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {
constexpr int kName = 0, kVertices = 1;
ItemId id_of(const QTreeWidgetItem* row) { return row->data(kName, Qt::UserRole).toUInt(); }
}  // namespace

MeshPanel::MeshPanel(Workbench& workbench, ActionTable& actions, QWidget* parent) : QWidget(parent), workbench_(workbench) {
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(8, 6, 8, 6);
  layout->setSpacing(5);
  list_ = new QTreeWidget(this);
  list_->setColumnCount(2);
  list_->setHeaderLabels({tr("Mesh"), tr("Vertices")});
  list_->header()->setSectionResizeMode(kName, QHeaderView::Stretch);
  list_->header()->setSectionResizeMode(kVertices, QHeaderView::ResizeToContents);
  list_->header()->setStretchLastSection(false);
  list_->setRootIsDecorated(false);
  list_->setEditTriggers(QAbstractItemView::DoubleClicked | QAbstractItemView::EditKeyPressed);
  list_->setToolTip(tr("The selected mesh is the active one. Tick: visible. Double click: new name."));
  list_->setMinimumHeight(70);
  layout->addWidget(list_, 1);

  auto* adding = new QHBoxLayout;
  add_ = new QPushButton(tr("Add sphere at crosshair"), this);
  add_->setToolTip(tr("A new mesh: a sphere about the crosshair"));
  radius_ = new QDoubleSpinBox(this);
  radius_->setRange(0.1, 500);
  radius_->setDecimals(1);
  radius_->setValue(20);
  radius_->setSuffix(tr(" mm"));
  radius_->setPrefix(tr("r "));
  radius_->setToolTip(tr("Radius of the sphere that a new mesh starts as"));
  adding->addWidget(add_, 1);
  adding->addWidget(radius_);
  layout->addLayout(adding);

  auto* grid = new QGridLayout;
  grid->setSpacing(5);
  int next = 0;
  const auto add_button = [&](const QString& title, const QString& tip, auto&& clicked) {
    auto* button = new QPushButton(title, this);
    button->setToolTip(tip);
    button->setMinimumWidth(40);
    connect(button, &QPushButton::clicked, this, clicked);
    const int columns = title.size() > 10 ? 2 : 1;
    grid->addWidget(button, next / 3, next % 3, 1, columns);
    next += columns;
    return button;
  };
  const auto active = [this] { return workbench_.view.active_mesh; };
  colour_ = add_button(tr("Colour..."), tr("Another colour for the active mesh"), [this] { choose_colour(); });
  reset_ = add_button(tr("Reset"), tr("The active mesh back to its sphere"),
                      [=, this] { workbench_.apply(ResetPose{active()}); });
  refine_ = add_button(tr("Refine"), tr("Four times as many vertices for the active mesh"),
                       [=, this] { workbench_.apply(RefineMesh{active()}); });
  record_ =
      add_button(tr("Record profiles"),
                 tr("Take the intensity profiles under the present pose as what the intensity-profile force looks for"),
                 [&actions] { actions[Act::RecordProfiles]->trigger(); });
  delete_ = add_button(tr("Delete"), tr("Delete the active mesh and its points"),
                       [=, this] { workbench_.apply(DeleteMesh{active()}); });
  layout->addLayout(grid);

  connect(add_, &QPushButton::clicked, this, &MeshPanel::add_at_crosshair);
  connect(list_, &QTreeWidget::itemChanged, this, &MeshPanel::edited);
  connect(list_, &QTreeWidget::currentItemChanged, this, [this](QTreeWidgetItem* row) {
    if (row) workbench_.set_active_mesh(id_of(row));
  });
  connect(&workbench_, &Workbench::scene_changed, this, &MeshPanel::refresh);
  connect(&workbench_, &Workbench::pose_changed, this, &MeshPanel::refresh_counts);  // meshes are refined as they move
  connect(&workbench_, &Workbench::volume_changed, this, [this] {
    if (!workbench_.has_volume()) return;
    const Eigen::Vector3d extent = world_box(workbench_.session().volume().geometry()).extent_mm();
    radius_->setValue(std::max(0.1, 0.1 * extent.minCoeff()));
  });
  refresh();
}

void MeshPanel::refresh() {
  const std::vector<MeshItem>& meshes = workbench_.scene().meshes;
  {
    const QSignalBlocker blocker(list_);
    while (list_->topLevelItemCount() > static_cast<int>(meshes.size()))
      delete list_->takeTopLevelItem(list_->topLevelItemCount() - 1);
    while (list_->topLevelItemCount() < static_cast<int>(meshes.size())) list_->addTopLevelItem(new QTreeWidgetItem);
    for (std::size_t m = 0; m < meshes.size(); ++m) {
      QTreeWidgetItem* row = list_->topLevelItem(static_cast<int>(m));
      const bool active = meshes[m].id == workbench_.view.active_mesh;
      row->setFlags(Qt::ItemIsEnabled | Qt::ItemIsSelectable | Qt::ItemIsEditable | Qt::ItemIsUserCheckable);
      row->setData(kName, Qt::UserRole, meshes[m].id);
      row->setText(kName, QString::fromStdString(meshes[m].name));
      row->setIcon(kName, swatch(meshes[m].colour, active));
      row->setCheckState(kName, meshes[m].visible ? Qt::Checked : Qt::Unchecked);
      row->setTextAlignment(kVertices, Qt::AlignRight | Qt::AlignVCenter);
      if (active) list_->setCurrentItem(row);
    }
  }
  counted_topology_ = ~std::uint64_t{0};
  refresh_counts();
  const QString no_volume = tr("Open a volume first");
  set_enabled(add_, workbench_.has_volume(), no_volume);
  set_enabled(radius_, workbench_.has_volume(), no_volume);
  const bool any = workbench_.active_mesh() != nullptr;
  for (QPushButton* button : {colour_, reset_, refine_, record_, delete_})
    set_enabled(button, any, tr("There is no mesh yet"));
}

void MeshPanel::refresh_counts() {
  if (counted_topology_ == workbench_.session().topology_revision()) return;
  counted_topology_ = workbench_.session().topology_revision();
  const QSignalBlocker blocker(list_);
  const std::vector<MeshItem>& meshes = workbench_.scene().meshes;
  for (int m = 0; m < list_->topLevelItemCount() && m < static_cast<int>(meshes.size()); ++m) {
    const QString count = QLocale::c().toString(meshes[m].mesh.vertex_count());
    QTreeWidgetItem* row = list_->topLevelItem(m);
    if (row->text(kVertices) != count) row->setText(kVertices, count);
  }
}

void MeshPanel::edited(QTreeWidgetItem* row, int column) {
  const MeshItem* item = workbench_.scene().find_mesh(id_of(row));
  if (!item || column != kName) return;
  EditMesh edit{item->id, {}, {}, {}, {}};
  const std::string name = row->text(kName).trimmed().toStdString();
  const bool visible = row->checkState(kName) == Qt::Checked;
  if (visible != item->visible) {
    edit.visible = visible;
  } else if (name != item->name && !name.empty()) {
    edit.name = name;
  } else {
    refresh();
    return;
  }
  if (!workbench_.apply(edit)) refresh();
}

void MeshPanel::add_at_crosshair() {
  workbench_.apply(
      AddMesh{{}, Seed{workbench_.view.crosshair_mm, radius_->value()}, std::nullopt, workbench_.view.active_mesh});
}

void MeshPanel::choose_colour() {
  const MeshItem* item = workbench_.active_mesh();
  if (!item) return;
  const ItemId id = item->id;
  const QColor chosen = QColorDialog::getColor(QColor(item->colour.red, item->colour.green, item->colour.blue), this,
                                               tr("Colour of %1").arg(QString::fromStdString(item->name)));
  if (!chosen.isValid()) return;
  EditMesh edit{id, {}, {}, {}, {}};
  edit.colour = Colour{static_cast<std::uint8_t>(chosen.red()), static_cast<std::uint8_t>(chosen.green()),
                       static_cast<std::uint8_t>(chosen.blue())};
  workbench_.apply(edit);
}

}  // namespace simplexseg
