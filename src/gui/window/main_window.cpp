// SPDX-License-Identifier: Apache-2.0
#include "gui/window/main_window.h"

#include <QAction>
#include <QActionGroup>
#include <QCloseEvent>
#include <QDragEnterEvent>
#include <QDropEvent>
#include <QFileDialog>
#include <QMenuBar>
#include <QMimeData>
#include <QSplitter>
#include <QToolBar>

#include "core/error.h"
#include "gui/input/action_table.h"
#include "gui/input/help.h"
#include "gui/input/key_return.h"
#include "gui/panels/simulation_panel.h"
#include "gui/views/drawn_scene.h"
#include "gui/views/view.h"
#include "gui/views/view_grid.h"
#include "gui/window/file_actions.h"
#include "gui/window/message_bar.h"
#include "gui/window/side_panels.h"
#include "gui/window/status_line.h"
#include "gui/window/workbench_actions.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/frame_loop.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

MainWindow::MainWindow(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> spare)
    : workbench_(std::make_unique<Workbench>(std::move(engine), std::move(spare))),
      drawn_(std::make_unique<DrawnScene>(*workbench_)),
      loop_(std::make_unique<FrameLoop>(*workbench_)) {
  setWindowTitle("SimplexSeg");
  setAcceptDrops(true);
  actions_ = new ActionTable(*this);
  job_ = new BackgroundJob(this);
  files_ = new FileActions(*workbench_, *job_, *actions_, *this);
  build_views();
  new WorkbenchActions(*workbench_, *views_, *actions_, this);
  connect_own_actions();
  build_menus();
  build_toolbar();
  setStatusBar(new StatusLine(*workbench_, *drawn_, this));
  connect_messages();
  resize(1280, 800);
}

// The views give back their OpenGL objects and the panels let go of the workbench before it goes.
MainWindow::~MainWindow() {
  delete job_;
  delete takeCentralWidget();
}

void MainWindow::build_views() {
  auto* centre = new QSplitter(Qt::Horizontal, this);
  centre->setChildrenCollapsible(false);
  views_ = new ViewGrid(*workbench_, *drawn_, centre);
  for (View* view : views_->all()) {
    connect(view, &View::about_to_paint, loop_.get(), &FrameLoop::view_about_to_paint);
    connect(view, &View::frameSwapped, loop_.get(), &FrameLoop::view_shown);
  }
  panels_ = new SidePanels(*workbench_, *loop_, *actions_, centre);
  centre->setStretchFactor(0, 1);
  centre->setStretchFactor(1, 0);
  messages_ = new MessageBar(views_);
  new KeyReturn(*this, *views_->all().front());
  setCentralWidget(centre);
}

void MainWindow::build_menus() {
  ActionTable& actions = *actions_;
  const auto fill = [&](const QString& title, std::initializer_list<std::initializer_list<Act>> groups) {
    QMenu* menu = menuBar()->addMenu(title);
    menu->setToolTipsVisible(true);
    for (const auto& group : groups) {
      if (!menu->isEmpty()) menu->addSeparator();
      for (const Act act : group) menu->addAction(actions[act]);
    }
    return menu;
  };
  fill(tr("&File"), {{Act::Open, Act::OpenFolder},
                     {Act::SaveScene, Act::SaveSceneAs},
                     {Act::SaveLabels, Act::SaveMeshes, Act::Screenshot},
                     {Act::Quit}});
  fill(tr("&Edit"), {{Act::Undo, Act::Redo}, {Act::DeletePoint}});
  fill(tr("&Tools"), {{Act::ToolCrosshair, Act::ToolZoomPan, Act::ToolSeed},
                      {Act::ToolPoint, Act::ToolInside, Act::ToolOutside},
                      {Act::WindowLevel}});
  fill(tr("&Mesh"), {{Act::ResetMesh, Act::RefineMesh, Act::RecordProfiles}, {Act::DeleteMesh}});
  fill(tr("&Simulation"), {{Act::RunPause, Act::Step, Act::ResetPose}});
  fill(tr("&View"), {{Act::CentreOnCrosshair, Act::Fit, Act::AutoContrast, Act::Neurological},
                     {Act::ShowMeshes, Act::ShowField, Act::Annotations, Act::Slices3d},
                     {Act::LessOpaque, Act::MoreOpaque},
                     {Act::ShowPanels, Act::Researcher}});
  fill(tr("&Help"), {{Act::Help, Act::Messages}, {Act::About}});
}

void MainWindow::build_toolbar() {
  QToolBar* bar = addToolBar(tr("Tools"));
  bar->setObjectName("tools");
  bar->setMovable(false);
  bar->setToolButtonStyle(Qt::ToolButtonTextOnly);
  bar->setContextMenuPolicy(Qt::PreventContextMenu);
  auto* group = new QActionGroup(this);
  for (const Act act :
       {Act::ToolCrosshair, Act::ToolZoomPan, Act::ToolSeed, Act::ToolPoint, Act::ToolInside, Act::ToolOutside}) {
    group->addAction((*actions_)[act]);
    bar->addAction((*actions_)[act]);
  }
  bar->addSeparator();
  for (const Act act : {Act::RunPause, Act::Step, Act::ResetPose}) bar->addAction((*actions_)[act]);
  bar->addSeparator();
  for (const Act act : {Act::Undo, Act::Redo}) bar->addAction((*actions_)[act]);
  bar->addSeparator();
  for (const Act act : {Act::WindowLevel, Act::AutoContrast, Act::Fit}) bar->addAction((*actions_)[act]);
}

void MainWindow::connect_own_actions() {
  ActionTable& actions = *actions_;
  actions.on(Act::Quit, [this] { close(); });
  actions.on(Act::Screenshot, [this] { choose_and_save_picture(); });
  actions.on(Act::Help, [this] { show_bindings(this); });
  actions.on_toggle(Act::ShowPanels, [this](bool shown) { panels_->setVisible(shown); });
  actions[Act::ShowPanels]->setChecked(true);
  actions.on(Act::Messages, [this] { messages_->show_log(); });
  actions.on(Act::About,
             [this] { show_about(this, QString::fromStdString(workbench_->session().engine().description())); });
}

void MainWindow::connect_messages() {
  connect(workbench_.get(), &Workbench::message, messages_, &MessageBar::show_message);
  connect(workbench_.get(), &Workbench::acted, messages_, &MessageBar::forget_failure);
  connect(job_, &BackgroundJob::started, messages_, &MessageBar::show_progress);
  connect(job_, &BackgroundJob::succeeded, messages_, &MessageBar::clear);
  connect(job_, &BackgroundJob::failed, this,
          [this](const QString& why) { messages_->show_message(Severity::Failure, why); });
  connect(drawn_.get(), &DrawnScene::manner_changed, this, [this] {
    const SceneBuffers& buffers = drawn_->buffers();
    panels_->simulation().show_drawing(
        tr("%1; OpenGL by %2").arg(QString::fromStdString(buffers.how()), QString::fromStdString(buffers.renderer())));
  });
  connect(files_, &FileActions::name_changed, this, [this] {
    const QString name = files_->scene_name();
    setWindowTitle(name.isEmpty() ? "SimplexSeg" : name + " - SimplexSeg");
  });
}

void MainWindow::save_picture(const QString& path) {
  if (!grab().save(path, "PNG")) {
    throw Error(path.toStdString(), "the picture could not be written", "choose another file or folder");
  }
}

void MainWindow::choose_and_save_picture() {
  const QString path = QFileDialog::getSaveFileName(this, tr("Save a picture of the window"),
                                                    files_->offered_path("", ".png"), tr("PNG (*.png)"));
  if (path.isEmpty()) return;
  try {
    save_picture(path);
    workbench_->say(Severity::Note, tr("Saved %1").arg(path));
  } catch (const std::exception& error) {
    workbench_->say(Severity::Failure, QString::fromUtf8(error.what()));
  }
}

void MainWindow::closeEvent(QCloseEvent* event) {
  if (!unattended_ && !files_->may_discard()) {
    event->ignore();
    return;
  }
  workbench_->pause();
  event->accept();
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
  if (event->mimeData()->hasUrls()) event->acceptProposedAction();
}

void MainWindow::dropEvent(QDropEvent* event) {
  event->acceptProposedAction();
  const QString path = FileActions::dropped_path(event->mimeData());
  if (path.isEmpty()) {
    workbench_->say(Severity::Warning, tr("What was dropped is not a file on this machine"));
  } else if (job_->busy()) {
    workbench_->say(Severity::Warning, tr("Wait for what is being loaded or saved"));
  } else {
    // Not within the drop: the question about unsaved changes would hold up the program dragged from.
    QMetaObject::invokeMethod(
        this, [this, path] { files_->open(path); }, Qt::QueuedConnection);
  }
}

}  // namespace simplexseg
