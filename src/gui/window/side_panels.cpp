// SPDX-License-Identifier: Apache-2.0
#include "gui/window/side_panels.h"

#include <QAction>
#include <QEvent>
#include <QTabWidget>
#include <utility>

#include "core/expect.h"
#include "gui/input/action_table.h"
#include "gui/look/theme.h"
#include "gui/panels/check_panel.h"
#include "gui/panels/convergence_panel.h"
#include "gui/panels/follow_panel.h"
#include "gui/panels/force_panel.h"
#include "gui/panels/intensity_panel.h"
#include "gui/panels/layer_panel.h"
#include "gui/panels/mesh_panel.h"
#include "gui/panels/plan_panel.h"
#include "gui/panels/point_panel.h"
#include "gui/panels/simulation_panel.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {
constexpr int kTallColumn = 930;  ///< smallest height of the column at which it has a third row of panels, pixels
constexpr int kMeshesHeight = 250;
constexpr int kWidth = 344;

QTabWidget* make_tabs() {
  auto* tabs = new QTabWidget;
  tabs->setDocumentMode(true);
  tabs->setUsesScrollButtons(false);  // long titles are elided instead, because hidden tabs are hard to find
  tabs->setElideMode(Qt::ElideRight);
  return tabs;
}
}  // namespace

SidePanels::SidePanels(Workbench& workbench, FrameLoop& loop, ActionTable& actions, QWidget* parent)
    : QSplitter(Qt::Vertical, parent),
      tabs_(make_tabs()),
      row_(make_tabs()),
      forces_(new ForcePanel(workbench, tabs_)),
      simulation_(new SimulationPanel(workbench, loop, actions, tabs_)),
      points_(new PointPanel(workbench, tabs_)),
      intensity_(new IntensityPanel(workbench, actions, tabs_)),
      check_(new CheckPanel(workbench, actions, tabs_)),
      layers_(new LayerPanel(workbench, actions, tabs_)),
      follow_(new FollowPanel(workbench, tabs_)),
      plan_(new PlanPanel(workbench, tabs_)),
      convergence_(new ConvergencePanel(workbench, tabs_)),
      actions_(actions) {
  setObjectName("side_panels");
  setChildrenCollapsible(false);
  setMinimumWidth(theme::scaled(kWidth));
  tabs_->setAccessibleName(tr("Panels"));
  row_->setAccessibleName(tr("Plan and convergence"));
  // QSplitter shows each widget that it contains as a row, so the tabs contain these panels.
  auto* meshes = new MeshPanel(workbench, loop, actions, nullptr);
  forces_->setObjectName(tr("Forces"));
  simulation_->setObjectName(tr("Simulation"));
  points_->setObjectName(tr("Points"));
  intensity_->setObjectName(tr("Intensity"));
  check_->setObjectName(tr("Check"));
  layers_->setObjectName(tr("Layers"));
  follow_->setObjectName(tr("Follow-up"));
  plan_->setObjectName(tr("Plan"));
  convergence_->setObjectName(tr("Convergence"));
  for (QWidget* panel : {static_cast<QWidget*>(check_), static_cast<QWidget*>(follow_), static_cast<QWidget*>(plan_),
                         static_cast<QWidget*>(convergence_)})
    panel->installEventFilter(this);
  addWidget(meshes);
  addWidget(tabs_);
  addWidget(row_);
  setStretchFactor(0, 0);
  setStretchFactor(1, 2);
  setStretchFactor(2, 3);
  actions.on_toggle(Act::Researcher, [this](bool researcher) { set_researcher(researcher); });
  set_researcher(false);
  connect(&workbench, &Workbench::scene_changed, this, [this, &workbench] { follow_scene(workbench.scene()); });
}

void SidePanels::follow_scene(const Scene& scene) {
  const bool filtered = !scene.volume_preprocessing.filters.empty();
  const int count = static_cast<int>(scene.layers.size()) + (filtered ? 1 : 0);
  const int before = std::exchange(layer_count_, count);
  const bool carried = has_follow_up(scene), carried_before = std::exchange(has_follow_up_, carried);
  if ((before == 0) != (count == 0) || carried != carried_before) arrange();
  if (count > before) show_panel(layers_->objectName());
  if (carried && !carried_before) show_panel(follow_->objectName());
}

bool SidePanels::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() == QEvent::Show || event->type() == QEvent::Hide) {
    const bool on_screen = event->type() == QEvent::Show;
    if (watched == check_) check_->set_on_screen(on_screen);
    if (watched == follow_) follow_->set_on_screen(on_screen);
    if (watched == plan_) plan_->set_on_screen(on_screen);
    if (watched == convergence_) convergence_->set_on_screen(on_screen);
  }
  return QSplitter::eventFilter(watched, event);
}

void SidePanels::resizeEvent(QResizeEvent* event) {
  QSplitter::resizeEvent(event);
  arrange();
}

void SidePanels::arrange() {
  const bool separate_row = researcher_ && height() >= kTallColumn;
  struct Place {
    QWidget* panel;
    QTabWidget* tabs;  ///< null: not in this layout
  };
  QTabWidget *const research = researcher_ ? tabs_ : nullptr, *const last = separate_row ? row_ : research;
  const Place places[] = {{forces_, research},
                          {simulation_, research},
                          {points_, tabs_},
                          {intensity_, tabs_},
                          {check_, tabs_},
                          {layers_, layer_count_ > 0 ? tabs_ : nullptr},
                          {follow_, has_follow_up_ ? tabs_ : nullptr},
                          {plan_, last},
                          {convergence_, last}};
  int next = 0;  // place among the tabs of tabs_
  for (const auto& [panel, target] : places) {
    for (QTabWidget* tabs : {tabs_, row_})
      if (const int at = tabs->indexOf(panel); at >= 0 && tabs != target) tabs->removeTab(at), panel->hide();
    if (target && target->indexOf(panel) < 0) {
      const int at = target->insertTab(target == tabs_ ? next : target->count(), panel, panel->objectName());
      target->setTabToolTip(at, panel->objectName());
    }
    if (!target) panel->hide();
    next += target == tabs_;
  }
  const int rows = separate_row ? 3 : 2;
  row_->setVisible(separate_row);
  if (rows == rows_ || height() < 2 * kMeshesHeight) return;
  rows_ = rows;
  const int rest = height() - kMeshesHeight;
  setSizes(separate_row ? QList<int>{kMeshesHeight, rest / 2, rest / 2} : QList<int>{kMeshesHeight, rest, 0});
}

void SidePanels::set_researcher(bool researcher) {
  researcher_ = researcher;
  actions_[Act::Researcher]->setChecked(researcher);
  for (const Act act : {Act::RefineMesh, Act::RecordProfiles, Act::Step, Act::Compare})
    actions_[act]->setVisible(researcher);
  arrange();
}

void SidePanels::show_panel(const QString& title) {
  const auto bring_forward = [&] {
    for (QTabWidget* tabs : {tabs_, row_})
      for (int n = 0; n < tabs->count(); ++n)
        if (tabs->tabText(n) == title) return tabs->setCurrentIndex(n), true;
    return false;
  };
  if (bring_forward()) return;
  set_researcher(true);
  const bool found = bring_forward();
  SIMPLEXSEG_EXPECT(found);
}

}  // namespace simplexseg
