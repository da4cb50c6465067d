// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QList>

class QDockWidget;
class QMainWindow;
class QString;
class QWidget;

namespace simplexseg {

class ActionTable;
class ConvergencePanel;
class ForcePanel;
class FrameLoop;
class PlanPanel;
class SimulationPanel;
class Workbench;

/// The panels, in a column of docks on the right of the window: Meshes, and below it the others behind tabs.
class PanelDocks {
 public:
  PanelDocks(QMainWindow& window, Workbench& workbench, FrameLoop& loop, ActionTable& actions);
  /// The panels go with their docks: they must let go of the workbench before it goes.
  ~PanelDocks();
  PanelDocks(const PanelDocks&) = delete;
  PanelDocks& operator=(const PanelDocks&) = delete;

  ForcePanel& forces() const { return *forces_; }
  SimulationPanel& simulation() const { return *simulation_; }
  PlanPanel& plan() const { return *plan_; }
  ConvergencePanel& convergence() const { return *convergence_; }
  /// In the order of the menu.
  const QList<QDockWidget*>& all() const { return docks_; }
  /// Brings the panel of this title, which must be one of them, to the front.
  void show(const QString& title);
  /// Suits the height of the window: in a tall one Plan and Convergence have a row of their own, so that what a slider
  /// does to the plan or the plot can be seen while it is moved.
  void arrange();

 private:
  QDockWidget* add(const QString& title, QWidget* panel);

  QMainWindow& window_;
  QList<QDockWidget*> docks_;
  ForcePanel* forces_;
  SimulationPanel* simulation_;
  PlanPanel* plan_;
  ConvergencePanel* convergence_;
  bool two_rows_ = false;  ///< Plan and Convergence have a row of their own
};

}  // namespace simplexseg
