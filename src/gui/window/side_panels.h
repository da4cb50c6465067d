// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QSplitter>

class QTabWidget;

namespace simplexseg {

class ActionTable;
class CheckPanel;
class ConvergencePanel;
class ForcePanel;
class FrameLoop;
class PlanPanel;
class PointPanel;
class SimulationPanel;
class Workbench;

/// The panels, in a column beside the views: Meshes, and below it the others behind tabs. Plan and Convergence are for
/// who tunes: they are there in the researcher's layout alone.
class SidePanels : public QSplitter {
 public:
  SidePanels(Workbench& workbench, FrameLoop& loop, ActionTable& actions, QWidget* parent);

  ForcePanel& forces() const { return *forces_; }
  SimulationPanel& simulation() const { return *simulation_; }
  CheckPanel& check() const { return *check_; }
  PlanPanel& plan() const { return *plan_; }
  ConvergencePanel& convergence() const { return *convergence_; }
  /// Brings a panel to the front, by its title, which must be one of theirs; into the researcher's layout where it is
  /// needed for that.
  void show_panel(const QString& title);
  void set_researcher(bool researcher);
  bool researcher() const { return researcher_; }

 protected:
  void resizeEvent(QResizeEvent* event) override;
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  /// Suits layout and height: in a tall window Plan and Convergence have a row of their own, so that what a slider does
  /// to the plan or the plot can be seen while it is moved.
  void arrange();

  QTabWidget* tabs_;
  QTabWidget* row_;  ///< the row of Plan and Convergence
  ForcePanel* forces_;
  SimulationPanel* simulation_;
  PointPanel* points_;
  CheckPanel* check_;
  PlanPanel* plan_;
  ConvergencePanel* convergence_;
  ActionTable& actions_;
  bool researcher_ = false;
  int rows_ = 0;  ///< among which the height was shared out last
};

}  // namespace simplexseg
