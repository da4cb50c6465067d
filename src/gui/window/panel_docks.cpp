// SPDX-License-Identifier: Apache-2.0
#include "gui/window/panel_docks.h"

#include <QDockWidget>
#include <QMainWindow>
#include <algorithm>

#include "core/expect.h"
#include "gui/panels/convergence_panel.h"
#include "gui/panels/force_panel.h"
#include "gui/panels/mesh_panel.h"
#include "gui/panels/plan_panel.h"
#include "gui/panels/point_panel.h"
#include "gui/panels/simulation_panel.h"

namespace simplexseg {
namespace {
constexpr int kTallWindow = 940;  ///< pixels of height from which on there is room for a third row
constexpr int kMeshesHeight = 230;
}  // namespace

PanelDocks::PanelDocks(QMainWindow& window, Workbench& workbench, FrameLoop& loop, ActionTable& actions)
    : window_(window),
      forces_(new ForcePanel(workbench, &window)),
      simulation_(new SimulationPanel(workbench, loop, actions, &window)),
      plan_(new PlanPanel(workbench, &window)),
      convergence_(new ConvergencePanel(workbench, &window)) {
  QDockWidget* meshes = add(QMainWindow::tr("Meshes"), new MeshPanel(workbench, &window));
  QDockWidget* forces = add(QMainWindow::tr("Forces"), forces_);
  QDockWidget* simulation = add(QMainWindow::tr("Simulation"), simulation_);
  QDockWidget* points = add(QMainWindow::tr("Points"), new PointPanel(workbench, &window));
  QDockWidget* plan = add(QMainWindow::tr("Plan"), plan_);
  QDockWidget* convergence = add(QMainWindow::tr("Convergence"), convergence_);
  window_.setTabPosition(Qt::RightDockWidgetArea, QTabWidget::North);
  // A dock that is added to the column and made a tab later leaves a separator behind in Qt 6.4.
  window_.addDockWidget(Qt::RightDockWidgetArea, meshes);
  window_.addDockWidget(Qt::RightDockWidgetArea, forces);
  QDockWidget* last = forces;
  for (QDockWidget* dock : {simulation, points, plan, convergence}) {
    window_.tabifyDockWidget(last, dock);
    last = dock;
  }
  // The tabs name them already.
  for (QDockWidget* dock : {forces, simulation, points, plan, convergence}) dock->setTitleBarWidget(new QWidget(dock));
  forces->raise();
  QObject::connect(plan, &QDockWidget::visibilityChanged, plan_, &PlanPanel::set_in_sight);
  QObject::connect(convergence, &QDockWidget::visibilityChanged, convergence_, &ConvergencePanel::set_in_sight);
  for (QDockWidget* dock : docks_) dock->widget()->setMinimumWidth(330);
  window_.resizeDocks({meshes, forces}, {340, 340}, Qt::Horizontal);
  window_.resizeDocks({meshes, forces}, {kMeshesHeight, 480}, Qt::Vertical);
}

PanelDocks::~PanelDocks() { qDeleteAll(docks_); }

QDockWidget* PanelDocks::add(const QString& title, QWidget* panel) {
  auto* dock = new QDockWidget(title, &window_);
  dock->setObjectName(title);
  dock->setWidget(panel);
  dock->setFeatures(QDockWidget::DockWidgetClosable);
  docks_.push_back(dock);
  return dock;
}

void PanelDocks::arrange() {
  const bool two_rows = window_.height() >= kTallWindow;
  if (two_rows == two_rows_) return;
  two_rows_ = two_rows;
  const auto dock_of = [](QWidget* panel) { return static_cast<QDockWidget*>(panel->parentWidget()); };
  QDockWidget *meshes = docks_.front(), *forces = dock_of(forces_), *plan = dock_of(plan_),
              *convergence = dock_of(convergence_);
  const int rest = window_.height() - kMeshesHeight;
  if (two_rows) {
    window_.addDockWidget(Qt::RightDockWidgetArea, plan, Qt::Vertical);
    window_.tabifyDockWidget(plan, convergence);
    plan->raise();
    window_.resizeDocks({meshes, forces, plan}, {kMeshesHeight, rest * 2 / 5, rest * 3 / 5}, Qt::Vertical);
  } else {
    window_.tabifyDockWidget(forces, plan);
    window_.tabifyDockWidget(plan, convergence);
    forces->raise();
    window_.resizeDocks({meshes, forces}, {kMeshesHeight, rest}, Qt::Vertical);
  }
}

void PanelDocks::show(const QString& title) {
  const auto found =
      std::find_if(docks_.begin(), docks_.end(), [&](QDockWidget* dock) { return dock->objectName() == title; });
  SIMPLEXSEG_EXPECT(found != docks_.end());
  (*found)->show();
  (*found)->raise();
}

}  // namespace simplexseg
