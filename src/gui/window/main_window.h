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
class FilterActions;
class FollowActions;
class FrameLoop;
class LayerActions;
class MessageBar;
class SidePanels;
class StartPage;
class StepStrip;
class ViewGrid;
class Workbench;

/// Main window: creates workbench, views, panels, menus and messages, and connects them.
class MainWindow : public QMainWindow {
  Q_OBJECT
 public:
  /// `make_fallback`: see Session.
  explicit MainWindow(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> make_fallback = {});
  ~MainWindow() override;

  Workbench& workbench() { return *workbench_; }
  DrawnScene& drawn() { return *drawn_; }
  FrameLoop& loop() { return *loop_; }
  ActionTable& actions() { return *actions_; }
  FileActions& files() { return *files_; }
  LayerActions& layers() { return *layers_; }
  FilterActions& filters() { return *filters_; }
  FollowActions& follow() { return *follow_; }
  ArchiveActions& archive() { return *archive_; }
  BackgroundJob& job() { return *job_; }
  MessageBar& messages() { return *messages_; }
  ViewGrid& views() { return *views_; }
  SidePanels& panels() { return *panels_; }
  StepStrip& steps() { return *steps_; }
  QDockWidget& history() { return *history_; }
  /// View menu, to which further entries can be added.
  QMenu* view_menu() const { return view_menu_; }
  StartPage& start_page() { return *start_; }

  /// Submenu of File with the recently opened files.
  QMenu* recent_menu() const { return findChild<QMenu*>("recent_menu"); }

  /// Saves a picture of the window as a PNG file. Throws Error when the file cannot be written.
  void save_picture(const QString& path);
  /// Sets the factory of the engines that compare two settings; the default factory makes CPU engines.
  void set_engine_maker(std::function<std::unique_ptr<Engine>()> make) { make_engine_ = std::move(make); }
  /// Opens a comparison of two settings of the active mesh. Returns null without an active mesh, and, with a message,
  /// if it fails.
  CompareWindow* compare_settings();
  /// Makes the window close without asking about unsaved changes; for runs without a user.
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
  void connect_title();
  void choose_and_save_picture();
  /// Returns a picture of the views on the screen, without messages.
  QImage picture_of_views();

  std::unique_ptr<Workbench> workbench_;
  std::unique_ptr<DrawnScene> drawn_;
  std::unique_ptr<FrameLoop> loop_;
  ActionTable* actions_ = nullptr;
  BackgroundJob* job_ = nullptr;
  FileActions* files_ = nullptr;
  LayerActions* layers_ = nullptr;
  FilterActions* filters_ = nullptr;
  FollowActions* follow_ = nullptr;
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
