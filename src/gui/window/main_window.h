// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QMainWindow>
#include <functional>
#include <memory>

class QDockWidget;
class QGridLayout;
class QLabel;

namespace simplexseg {

class ActionTable;
class BackgroundJob;
class ConvergencePanel;
class DrawnScene;
class Engine;
class FileActions;
class ForcePanel;
class FrameLoop;
class MessageBar;
class PlanPanel;
class SimulationPanel;
class SliceView;
class SpaceView;
class View;
class Workbench;

/// Puts the parts together: four views, panels, menus, messages. What they do is theirs.
class MainWindow : public QMainWindow {
  Q_OBJECT
 public:
  /// `spare`: as of Session.
  explicit MainWindow(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> spare = {});
  ~MainWindow() override;

  Workbench& workbench() { return *workbench_; }
  DrawnScene& drawn() { return *drawn_; }
  FrameLoop& loop() { return *loop_; }
  FileActions& files() { return *files_; }
  ActionTable& actions() { return *actions_; }
  MessageBar& messages() { return *messages_; }
  ForcePanel& forces() { return *forces_; }
  SimulationPanel& simulation() { return *simulation_; }
  PlanPanel& plan() { return *plan_; }
  ConvergencePanel& convergence() { return *convergence_; }
  /// Brings the panel of this title to the front.
  void show_panel(const QString& title);
  SliceView& slice(int orientation) { return *slices_[orientation]; }
  SpaceView& space() { return *space_; }
  /// nullptr: all four.
  View* maximised() const { return maximised_; }

  /// The window as it is on the screen, as a PNG file. Throws Error when it cannot be written.
  void save_picture(const QString& path);
  /// Leaving asks no questions: for runs without a user.
  void set_unattended() { unattended_ = true; }

 protected:
  void resizeEvent(QResizeEvent* event) override;
  void closeEvent(QCloseEvent* event) override;
  void dragEnterEvent(QDragEnterEvent* event) override;
  void dropEvent(QDropEvent* event) override;

 private:
  void build_views();
  void build_panels();
  void arrange_panels();
  void build_menus();
  void build_toolbar();
  void build_status();
  void connect_actions();
  void connect_messages();
  void refresh_actions();
  void refresh_readout();
  void refresh_drawing();
  void maximise(View* view);
  void change_opacity(float by);
  void choose_and_save_picture();

  std::unique_ptr<Workbench> workbench_;
  std::unique_ptr<DrawnScene> drawn_;
  std::unique_ptr<FrameLoop> loop_;
  ActionTable* actions_ = nullptr;
  BackgroundJob* job_ = nullptr;
  FileActions* files_ = nullptr;
  MessageBar* messages_ = nullptr;
  ForcePanel* forces_ = nullptr;
  SimulationPanel* simulation_ = nullptr;
  PlanPanel* plan_ = nullptr;
  ConvergencePanel* convergence_ = nullptr;
  SliceView* slices_[3] = {};
  SpaceView* space_ = nullptr;
  QGridLayout* view_grid_ = nullptr;
  View* maximised_ = nullptr;
  QList<QDockWidget*> docks_;
  bool plan_below_ = false;  ///< Plan and Convergence have a row of their own
  QLabel* readout_ = nullptr;
  QLabel* contrast_ = nullptr;
  QLabel* drawing_ = nullptr;
  bool unattended_ = false;
};

}  // namespace simplexseg
