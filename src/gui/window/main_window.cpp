// SPDX-License-Identifier: Apache-2.0
// How the window is put together. What its menu entries do: main_window_actions.cpp.
#include "gui/window/main_window.h"

#include <QAction>
#include <QActionGroup>
#include <QDockWidget>
#include <QGridLayout>
#include <QLabel>
#include <QMenuBar>
#include <QStatusBar>
#include <QToolBar>
#include <QVBoxLayout>

#include "gui/input/action_table.h"
#include "gui/panels/convergence_panel.h"
#include "gui/panels/force_panel.h"
#include "gui/panels/mesh_panel.h"
#include "gui/panels/plan_panel.h"
#include "gui/panels/point_panel.h"
#include "gui/panels/simulation_panel.h"
#include "gui/views/drawn_scene.h"
#include "gui/views/slice_view.h"
#include "gui/views/space_view.h"
#include "gui/window/file_actions.h"
#include "gui/window/message_bar.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/frame_loop.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {
constexpr int kTallWindow = 940;  ///< pixels of height from which on Plan and Convergence have a row of their own
}  // namespace

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
  connect_actions();
  build_panels();
  build_menus();
  build_toolbar();
  build_status();
  connect_messages();
  refresh_actions();
  refresh_readout();
  resize(1280, 800);
}

// The views give back their OpenGL objects and the panels let go of the workbench before it goes.
MainWindow::~MainWindow() {
  delete job_;
  delete takeCentralWidget();
  for (QDockWidget* dock : docks_) delete dock;
}

void MainWindow::build_views() {
  auto* centre = new QWidget(this);
  auto* column = new QVBoxLayout(centre);
  column->setContentsMargins(0, 0, 0, 0);
  column->setSpacing(0);
  messages_ = new MessageBar(centre);
  column->addWidget(messages_);
  auto* views = new QWidget(centre);
  view_grid_ = new QGridLayout(views);
  view_grid_->setContentsMargins(2, 2, 2, 2);
  view_grid_->setSpacing(3);
  for (const Orientation orientation : kOrientations) {
    slices_[static_cast<int>(orientation)] = new SliceView(*workbench_, *drawn_, orientation, views);
  }
  space_ = new SpaceView(*workbench_, *drawn_, views);
  View* const order[] = {slices_[0], slices_[1], slices_[2], space_};
  for (int n = 0; n < 4; ++n) {
    view_grid_->addWidget(order[n], n / 2, n % 2);
    view_grid_->setRowStretch(n / 2, 1);
    view_grid_->setColumnStretch(n % 2, 1);
    connect(order[n], &View::maximise_wanted, this, [this, view = order[n]] { maximise(view); });
    connect(order[n], &View::painted, loop_.get(), &FrameLoop::view_painted);
    connect(order[n], &View::frameSwapped, loop_.get(), &FrameLoop::view_shown);
  }
  column->addWidget(views, 1);
  setCentralWidget(centre);
}

void MainWindow::build_panels() {
  const auto add = [&](const QString& title, QWidget* content) {
    auto* dock = new QDockWidget(title, this);
    dock->setObjectName(title);
    dock->setWidget(content);
    dock->setFeatures(QDockWidget::DockWidgetClosable);
    docks_.push_back(dock);
    return dock;
  };
  forces_ = new ForcePanel(*workbench_, this);
  simulation_ = new SimulationPanel(*workbench_, *loop_, *actions_, this);
  plan_ = new PlanPanel(*workbench_, this);
  convergence_ = new ConvergencePanel(*workbench_, this);
  QDockWidget* meshes = add(tr("Meshes"), new MeshPanel(*workbench_, this));
  QDockWidget* forces = add(tr("Forces"), forces_);
  QDockWidget* simulation = add(tr("Simulation"), simulation_);
  QDockWidget* points = add(tr("Points"), new PointPanel(*workbench_, this));
  QDockWidget* plan = add(tr("Plan"), plan_);
  QDockWidget* convergence = add(tr("Convergence"), convergence_);
  setTabPosition(Qt::RightDockWidgetArea, QTabWidget::North);
  // A dock that is added to the column and made a tab later leaves a separator behind in Qt 6.4.
  addDockWidget(Qt::RightDockWidgetArea, meshes);
  addDockWidget(Qt::RightDockWidgetArea, forces);
  QDockWidget* last = forces;
  for (QDockWidget* dock : {simulation, points, plan, convergence}) {
    tabifyDockWidget(last, dock);
    last = dock;
  }
  // The tabs name them already.
  for (QDockWidget* dock : {forces, simulation, points, plan, convergence}) dock->setTitleBarWidget(new QWidget(dock));
  forces->raise();
  connect(plan, &QDockWidget::visibilityChanged, plan_, &PlanPanel::set_in_sight);
  connect(convergence, &QDockWidget::visibilityChanged, convergence_, &ConvergencePanel::set_in_sight);
  for (QDockWidget* dock : docks_) dock->widget()->setMinimumWidth(330);
  resizeDocks({meshes, forces}, {340, 340}, Qt::Horizontal);
  resizeDocks({meshes, forces}, {230, 480}, Qt::Vertical);
}

// In a tall window what a slider does to the plan or the plot can be seen while it is moved.
void MainWindow::arrange_panels() {
  const bool below = height() >= kTallWindow;
  if (below == plan_below_) return;
  plan_below_ = below;
  const auto dock_of = [](QWidget* panel) { return static_cast<QDockWidget*>(panel->parentWidget()); };
  QDockWidget *meshes = docks_.front(), *forces = dock_of(forces_), *plan = dock_of(plan_),
              *convergence = dock_of(convergence_);
  if (below) {
    addDockWidget(Qt::RightDockWidgetArea, plan, Qt::Vertical);
    tabifyDockWidget(plan, convergence);
    plan->raise();
    const int rest = height() - 230;
    resizeDocks({meshes, forces, plan}, {230, rest * 2 / 5, rest * 3 / 5}, Qt::Vertical);
  } else {
    tabifyDockWidget(forces, plan);
    tabifyDockWidget(plan, convergence);
    forces->raise();
    resizeDocks({meshes, forces}, {230, height() - 230}, Qt::Vertical);
  }
}

void MainWindow::resizeEvent(QResizeEvent* event) {
  QMainWindow::resizeEvent(event);
  // Not within the layout that this event is part of.
  QMetaObject::invokeMethod(this, &MainWindow::arrange_panels, Qt::QueuedConnection);
}

void MainWindow::show_panel(const QString& title) {
  for (QDockWidget* dock : docks_) {
    if (dock->objectName() != title) continue;
    dock->show();
    dock->raise();
  }
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
  fill(tr("&Tools"), {{Act::ToolCrosshair, Act::ToolZoomPan, Act::ToolPoint, Act::ToolSeed}, {Act::WindowLevel}});
  fill(tr("&Simulation"), {{Act::RunPause, Act::Step, Act::ResetPose}});
  QMenu* view = fill(tr("&View"), {{Act::CentreOnCursor, Act::Fit, Act::AutoContrast, Act::Neurological},
                                   {Act::ShowMeshes, Act::Annotations, Act::Slices3d},
                                   {Act::LessOpaque, Act::MoreOpaque}});
  view->addSeparator();
  for (QDockWidget* dock : docks_) view->addAction(dock->toggleViewAction());
  fill(tr("&Help"), {{Act::Help, Act::About}});
}

void MainWindow::build_toolbar() {
  QToolBar* bar = addToolBar(tr("Tools"));
  bar->setObjectName("tools");
  bar->setMovable(false);
  bar->setToolButtonStyle(Qt::ToolButtonTextOnly);
  bar->setContextMenuPolicy(Qt::PreventContextMenu);
  auto* group = new QActionGroup(this);
  for (const Act act : {Act::ToolCrosshair, Act::ToolZoomPan, Act::ToolPoint, Act::ToolSeed}) {
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

void MainWindow::build_status() {
  readout_ = new QLabel(this);
  contrast_ = new QLabel(this);
  drawing_ = new QLabel(this);
  for (QLabel* label : {readout_, drawing_, contrast_}) label->setContentsMargins(8, 0, 8, 0);
  drawing_->setMinimumWidth(1);  // the first to give way in a narrow window
  drawing_->setStyleSheet("color: #969ca4;");
  readout_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  statusBar()->addWidget(readout_, 1);
  statusBar()->addPermanentWidget(drawing_);
  statusBar()->addPermanentWidget(contrast_);
  statusBar()->setSizeGripEnabled(false);
}

void MainWindow::connect_messages() {
  connect(workbench_.get(), &Workbench::message, messages_, &MessageBar::show_message);
  connect(job_, &BackgroundJob::started, messages_, &MessageBar::show_progress);
  connect(job_, &BackgroundJob::succeeded, messages_, &MessageBar::clear);
  connect(job_, &BackgroundJob::failed, this,
          [this](const QString& why) { messages_->show_message(Severity::Failure, why); });
  connect(workbench_.get(), &Workbench::scene_changed, this, &MainWindow::refresh_actions);
  connect(workbench_.get(), &Workbench::running_changed, this, &MainWindow::refresh_actions);
  connect(workbench_.get(), &Workbench::view_changed, this, &MainWindow::refresh_readout);
  connect(drawn_.get(), &DrawnScene::manner_changed, this, &MainWindow::refresh_drawing);
  connect(files_, &FileActions::name_changed, this, [this] {
    const QString name = files_->scene_name();
    setWindowTitle(name.isEmpty() ? "SimplexSeg" : name + " - SimplexSeg");
  });
}

}  // namespace simplexseg
