// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QMainWindow>
#include <QMenu>
#include <functional>
#include <memory>

class QDockWidget;

namespace simplexseg {

class ActionTable;
class ArchiveActions;
class BackgroundJob;
class CompareWindow;
class DrawnScene;
class Engine;
class FileActions;
class FrameLoop;
class MessageBar;
class SidePanels;
class StartPage;
class StepStrip;
class ViewGrid;
class Workbench;

/// Puts the parts together: workbench, views, panels, menus, messages. What they do is theirs.
class MainWindow : public QMainWindow {
  Q_OBJECT
 public:
  /// `spare`: as Session takes it.
  explicit MainWindow(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> spare = {});
  ~MainWindow() override;

  Workbench& workbench() { return *workbench_; }
  DrawnScene& drawn() { return *drawn_; }
  FrameLoop& loop() { return *loop_; }
  ActionTable& actions() { return *actions_; }
  FileActions& files() { return *files_; }
  ArchiveActions& archive() { return *archive_; }
  BackgroundJob& job() { return *job_; }
  MessageBar& messages() { return *messages_; }
  ViewGrid& views() { return *views_; }
  SidePanels& panels() { return *panels_; }
  StepStrip& steps() { return *steps_; }
  QDockWidget& history() { return *history_; }
  /// The menu View, for what is added to it.
  QMenu* view_menu() const { return view_menu_; }
  StartPage& start_page() { return *start_; }

  /// In the menu File, for the files that were opened last.
  QMenu* recent_menu() const { return findChild<QMenu*>("recent_menu"); }

  /// The window as it is on the screen, as a PNG file. Throws Error when it cannot be written.
  void save_picture(const QString& path);
  /// What computes where two settings are compared; without it the CPU.
  void set_engine_maker(std::function<std::unique_ptr<Engine>()> make) { make_engine_ = std::move(make); }
  /// Compares two settings of the active mesh; null, with a message, where that cannot be.
  CompareWindow* compare_settings();
  /// Leaving asks no questions: for runs without a user.
  void set_unattended() { unattended_ = true; }

 protected:
  void closeEvent(QCloseEvent* event) override;
  void dragEnterEvent(QDragEnterEvent* event) override;
  void dropEvent(QDropEvent* event) override;

 private:
  void build_views();
  void build_history();
  void build_menus();
  void build_toolbar();
  void connect_own_actions();
  void connect_messages();
  void choose_and_save_picture();
  /// As they are on the screen, without messages.
  QImage picture_of_views();

  std::unique_ptr<Workbench> workbench_;
  std::unique_ptr<DrawnScene> drawn_;
  std::unique_ptr<FrameLoop> loop_;
  ActionTable* actions_ = nullptr;
  BackgroundJob* job_ = nullptr;
  FileActions* files_ = nullptr;
  ArchiveActions* archive_ = nullptr;
  MessageBar* messages_ = nullptr;
  ViewGrid* views_ = nullptr;
  SidePanels* panels_ = nullptr;
  StepStrip* steps_ = nullptr;
  StartPage* start_ = nullptr;
  QDockWidget* history_ = nullptr;
  QMenu* view_menu_ = nullptr;
  bool unattended_ = false;
  std::function<std::unique_ptr<Engine>()> make_engine_;
};

}  // namespace simplexseg
