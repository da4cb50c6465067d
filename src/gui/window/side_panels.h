// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QSplitter>

class QTabWidget;

namespace simplexseg {

class ActionTable;
class CheckPanel;
class IntensityPanel;
class LayerPanel;
class ConvergencePanel;
class FollowPanel;
class ForcePanel;
class FrameLoop;
class PlanPanel;
class PointPanel;
class SimulationPanel;
class Workbench;
struct Scene;

/// Column of panels beside the views: the panel Segmentations, and tabs with the other panels below. The clinician's
/// layout, the default, has Points and Check; the researcher's layout adds Forces, Simulation, Plan and Convergence,
/// and the actions for them.
class SidePanels : public QSplitter {
 public:
  SidePanels(Workbench& workbench, FrameLoop& loop, ActionTable& actions, QWidget* parent);

  ForcePanel& forces() const { return *forces_; }
  SimulationPanel& simulation() const { return *simulation_; }
  CheckPanel& check() const { return *check_; }
  PlanPanel& plan() const { return *plan_; }
  ConvergencePanel& convergence() const { return *convergence_; }
  /// Brings the panel with this title to the front, in the researcher's layout if the panel needs it. The title must
  /// exist.
  void show_panel(const QString& title);
  void set_researcher(bool researcher);
  bool researcher() const { return researcher_; }

 protected:
  void resizeEvent(QResizeEvent* event) override;
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  /// Adapts the rows to layout and height. In a tall window Plan and Convergence have a separate row, so that they stay
  /// visible while a slider is moved.
  void arrange();
  /// Adapts the tabs of layers and follow-up to the scene.
  void follow_scene(const Scene& scene);

  QTabWidget* tabs_;
  QTabWidget* row_;  ///< row of Plan and Convergence
  ForcePanel* forces_;
  SimulationPanel* simulation_;
  PointPanel* points_;
  IntensityPanel* intensity_;
  CheckPanel* check_;
  LayerPanel* layers_;   ///< a tab while the scene has layers
  FollowPanel* follow_;  ///< a tab while the scene has meshes of an earlier study
  PlanPanel* plan_;
  ConvergencePanel* convergence_;
  ActionTable& actions_;
  bool researcher_ = false;
  int layer_count_ = 0;
  bool has_follow_up_ = false;
  int rows_ = 0;  ///< number of rows for which the height was last distributed
};

}  // namespace simplexseg
