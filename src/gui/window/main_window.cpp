// SPDX-License-Identifier: Apache-2.0
#include "gui/window/main_window.h"

#include <QAction>
#include <QActionGroup>
#include <QBuffer>
#include <QCloseEvent>
#include <QDockWidget>
#include <QDragEnterEvent>
#include <QDropEvent>
#include <QMenuBar>
#include <QMimeData>
#include <QProxyStyle>
#include <QSplitter>
#include <QToolBar>
#include <QToolButton>
#include <QVBoxLayout>

#include "gpu/backend.h"
#include "gui/input/action_table.h"
#include "gui/input/focus_return.h"
#include "gui/input/help.h"
#include "gui/input/pointer_at_keys.h"
#include "gui/look/contrast.h"
#include "gui/look/qt_text.h"
#include "gui/look/symbols.h"
#include "gui/look/widgets.h"
#include "gui/panels/history_panel.h"
#include "gui/panels/label_preset_menu.h"
#include "gui/panels/simulation_panel.h"
#include "gui/views/drawn_scene.h"
#include "gui/views/space_view.h"
#include "gui/views/view.h"
#include "gui/views/view_grid.h"
#include "gui/window/archive_actions.h"
#include "gui/window/compare/compare_window.h"
#include "gui/window/file_actions.h"
#include "gui/window/filter_actions.h"
#include "gui/window/follow_actions.h"
#include "gui/window/image_menu.h"
#include "gui/window/key_dialog.h"
#include "gui/window/label_actions.h"
#include "gui/window/layer_actions.h"
#include "gui/window/message_bar.h"
#include "gui/window/model_menu.h"
#include "gui/window/name_popup.h"
#include "gui/window/network_actions.h"
#include "gui/window/side_panels.h"
#include "gui/window/space_menus.h"
#include "gui/window/start_page.h"
#include "gui/window/state_chip.h"
#include "gui/window/status_line.h"
#include "gui/window/step_strip.h"
#include "gui/window/view_layout_menu.h"
#include "gui/window/voxel_menu.h"
#include "gui/window/workbench_actions.h"
#include "gui/workbench/ask_and_save.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/frame_loop.h"
#include "gui/workbench/workbench.h"
#include "io/platform/atomic_file.h"

namespace simplexseg {
namespace {

/// Style that widens the extension button of a toolbar, so that it is easy to hit.
class WideExtensionStyle : public QProxyStyle {
 public:
  WideExtensionStyle() : QProxyStyle("Fusion") {}
  int pixelMetric(PixelMetric metric, const QStyleOption* option, const QWidget* widget) const override {
    constexpr int kWidth = 26;
    return metric == PM_ToolBarExtensionExtent ? kWidth : QProxyStyle::pixelMetric(metric, option, widget);
  }
};

/// Adds one button for the tools that measure, which shows the tool chosen last, and returns their actions.
QList<QAction*> add_measure_button(QToolBar& bar, ActionTable& actions) {
  auto* button = new QToolButton(&bar);
  button->setObjectName("measure");
  auto* menu = new QMenu(button);
  menu->setToolTipsVisible(true);
  for (const auto& [act, symbol, text] : {std::tuple(Act::ToolRuler, Symbol::Ruler, MainWindow::tr("Ruler")),
                                          {Act::ToolAngle, Symbol::Angle, MainWindow::tr("Angle")},
                                          {Act::ToolEllipse, Symbol::Ellipse, MainWindow::tr("Ellipse")}}) {
    QAction* tool = actions[act];
    tool->setIcon(icon_of(symbol));
    tool->setIconText(text);
    menu->addAction(tool);
    QObject::connect(tool, &QAction::toggled, button, [=](bool chosen) {
      if (chosen) button->setDefaultAction(tool);
    });
  }
  button->setDefaultAction(actions[Act::ToolRuler]);
  button->setMenu(menu);
  button->setPopupMode(QToolButton::MenuButtonPopup);
  button->setToolButtonStyle(Qt::ToolButtonTextUnderIcon);
  button->setIconSize(bar.iconSize());
  constexpr int kArrow = 40;  // the arrow, and margins on both sides
  button->setMinimumWidth(button->fontMetrics().horizontalAdvance(MainWindow::tr("Ellipse")) + kArrow);
  bar.addWidget(button);
  return menu->actions();
}

}  // namespace

MainWindow::MainWindow(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> make_fallback)
    : workbench_(std::make_unique<Workbench>(std::move(engine), std::move(make_fallback))),
      drawn_(std::make_unique<DrawnScene>(*workbench_)),
      loop_(std::make_unique<FrameLoop>(*workbench_)),
      make_engine_([] { return make_cpu_engine(); }) {
  setWindowTitle("SimplexSeg[*]");
  setAcceptDrops(true);
  actions_ = new ActionTable(*this);
  job_ = new BackgroundJob(this);
  files_ = new FileActions(*workbench_, *job_, *actions_, *this);
  new LabelActions(*workbench_, *job_, *files_, *actions_, *this);
  layers_ = new LayerActions(*workbench_, *job_, *files_, *actions_, *this);
  filters_ = new FilterActions(*workbench_, *job_, *actions_, *this);
  follow_ = new FollowActions(
      *workbench_, *job_, *files_, *actions_, [this] { return std::make_unique<Session>(make_engine_()); }, *this);
  new NetworkActions(*workbench_, *actions_, *this);
  build_views();
  archive_ = new ArchiveActions(
      *workbench_, *job_, *files_, *actions_, [this] { return picture_of_views(); }, *this);
  new WorkbenchActions(*workbench_, *loop_, *views_, *actions_, this);
  connect_own_actions();
  build_history();
  build_menus();
  build_toolbar();
  setStatusBar(new StatusLine(*workbench_, *drawn_, this));
  connect_messages();
  connect_title();
  resize(1280, 800);
}

// Deletes the views and panels before the workbench and the OpenGL buffers that they use.
MainWindow::~MainWindow() {
  delete job_;
  delete history_;
  delete takeCentralWidget();
}

void MainWindow::build_views() {
  auto* centre = new QSplitter(Qt::Horizontal, this);
  centre->setChildrenCollapsible(false);
  auto* middle = new QWidget(centre);
  auto* column = new QVBoxLayout(middle);
  column->setContentsMargins(0, 0, 0, 0);
  column->setSpacing(0);
  steps_ = new StepStrip(*workbench_, *actions_, middle);
  column->addWidget(steps_);
  views_ = new ViewGrid(*workbench_, *drawn_, middle);
  column->addWidget(views_, 1);
  for (View* view : views_->every()) {
    connect(view, &View::about_to_paint, loop_.get(), &FrameLoop::view_about_to_paint);
    connect(view, &View::aboutToCompose, loop_.get(), &FrameLoop::view_composing);
    connect(view, &View::frameSwapped, loop_.get(), &FrameLoop::view_shown);
  }
  panels_ = new SidePanels(*workbench_, *loop_, *actions_, centre);
  centre->setStretchFactor(0, 1);
  centre->setStretchFactor(1, 0);
  start_ = new StartPage(*actions_, views_);
  connect(start_, &StartPage::open_requested, files_, &FileActions::open);
  connect(workbench_.get(), &Workbench::volume_changed, this,
          [this] { start_->setVisible(!workbench_->has_volume()); });
  messages_ = new MessageBar(views_);
  auto* name = new NamePopup(*workbench_, *views_);
  actions_->on(Act::NameMesh, [name] { name->ask(); });
  new FocusReturn(*this, *views_->all().front());
  new PointerAtKeys(this);
  setCentralWidget(centre);
}

void MainWindow::build_history() {
  history_ = new QDockWidget(tr("History"), this);
  history_->setObjectName("history_dock");
  history_->setWidget(new HistoryPanel(*workbench_, history_));
  addDockWidget(Qt::LeftDockWidgetArea, history_);
  history_->hide();
  QAction* entry = (*actions_)[Act::History];
  actions_->on_toggle(Act::History, [this](bool shown) { history_->setVisible(shown); });
  connect(history_, &QDockWidget::visibilityChanged, this,
          [this, entry] { entry->setChecked(history_->isVisibleTo(this)); });
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
  QMenu* file = fill(tr("&File"), {{Act::Open, Act::OpenFolder, Act::OpenReference},
                                   {Act::Archive, Act::SendBack},
                                   {Act::FollowStudy, Act::FollowTimePoints},
                                   {Act::SaveScene, Act::SaveSceneAs},
                                   {Act::SaveLabels, Act::SaveMeshes, Act::SaveMeasurements, Act::Screenshot},
                                   {Act::Quit}});
  auto* recent = new QMenu(tr("Open rece&nt"), file);
  recent->setObjectName("recent_menu");
  recent->setEnabled(false);
  file->insertMenu(file->actions().at(2), recent);
  fill(tr("&Edit"), {{Act::Undo, Act::Redo, Act::History},
                     {Act::BoundaryHere, Act::InsideHere, Act::OutsideHere, Act::PointHere, Act::DeletePoint}});
  fill(tr("&Tools"), {{Act::ToolCrosshair, Act::ToolZoomPan, Act::ToolSeed, Act::ToolBox},
                      {Act::ToolPoint, Act::ToolInside, Act::ToolOutside},
                      {Act::ToolBrush, Act::ToolEraser, Act::ToolFreeze},
                      {Act::Brush3d, Act::Lasso, Act::SmartBrush, Act::LocalMarks},
                      {Act::ToolRange},
                      {Act::ToolRuler, Act::ToolAngle, Act::ToolEllipse},
                      {Act::WindowLevel}});
  QMenu* segmentation = fill(tr("Se&gmentation"),
                             {{Act::NameMesh},
                              {Act::ResetMesh, Act::RefineMesh, Act::RecordProfiles, Act::LockMesh, Act::DuplicateMesh},
                              {Act::MeshFromLabels, Act::MeshFromFile},
                              {Act::MeshUp, Act::MeshDown},
                              {Act::WorstFit},
                              {Act::DeleteMesh}});
  segmentation->insertMenu(segmentation->actions().at(1), new LabelPresetMenu(*workbench_, segmentation));
  segmentation->insertMenu(actions[Act::MeshFromLabels], new VoxelMenu(*workbench_, segmentation));
  segmentation->insertMenu(actions[Act::MeshFromLabels], new ModelMenu(*workbench_, segmentation));
  segmentation->insertAction(actions[Act::MeshFromLabels], actions[Act::NetworkStart]);
  segmentation->insertMenu(actions[Act::MeshFromLabels], new ImageMenu(*workbench_, segmentation));
  layers_->fill(*menuBar()->addMenu(tr("&Layers")));
  fill(tr("&Simulation"), {{Act::RunPause, Act::Step, Act::CancelSolving, Act::ResetPose}, {Act::Compare}});
  QMenu* const view = view_menu_ = fill(
      tr("&View"),
      {{Act::CentreOnCrosshair, Act::Fit, Act::AutoContrast, Act::Neurological},
       {Act::ShowMeshes, Act::ShowFill, Act::ShowField, Act::ShowAxes, Act::Annotations, Act::Names, Act::Slices3d},
       {Act::LessOpaque, Act::MoreOpaque},
       {Act::ShowPanels, Act::ShowSteps, Act::Researcher}});
  view->addMenu(new ViewLayoutMenu(*views_, view));
  view->addMenu(new ClipMenu(*workbench_, views_->space(), actions, view));
  view->addMenu(new VolumeMenu(*workbench_, views_->space(), actions, view));
  QMenu* presets = view->addMenu(tr("Window and level &presets"));
  for (const ContrastPreset& preset : contrast_presets()) {
    QAction* entry = presets->addAction(tr(preset.title));
    entry->setToolTip(tr("Window %1, level %2").arg(preset.window).arg(preset.level));
    connect(entry, &QAction::triggered, this, [this, preset] {
      workbench_->view.window = preset.window;
      workbench_->view.level = preset.level;
      workbench_->view_edited();
    });
  }
  presets->setToolTipsVisible(true);
  const auto enable = [this, presets] {
    set_enabled(presets->menuAction(), workbench_->has_volume(), tr("Open a volume first"));
  };
  enable();
  connect(workbench_.get(), &Workbench::volume_changed, presets, enable);
  fill(tr("&Help"), {{Act::Help, Act::ChangeKeys, Act::Messages}, {Act::About}});
}

void MainWindow::build_toolbar() {
  QToolBar* bar = addToolBar(tr("Tools"));
  bar->setObjectName("tools");
  bar->setMovable(false);
  bar->setToolButtonStyle(Qt::ToolButtonTextUnderIcon);
  bar->setIconSize({20, 20});
  bar->setContextMenuPolicy(Qt::PreventContextMenu);
  struct Entry {
    Act act;
    Symbol symbol;
    QString text;
  };
  const auto add = [&](std::initializer_list<Entry> entries) {
    for (const auto& [act, symbol, text] : entries) {
      QAction* action = (*actions_)[act];
      action->setIcon(icon_of(symbol));
      action->setIconText(text);
      bar->addAction(action);
    }
  };
  add({{Act::ToolCrosshair, Symbol::Crosshair, tr("Crosshair")},
       {Act::ToolZoomPan, Symbol::ZoomPan, tr("Zoom")},
       {Act::ToolSeed, Symbol::Seed, tr("Seed")},
       {Act::ToolBox, Symbol::Box, tr("Box")},
       {Act::ToolPoint, Symbol::Boundary, tr("Boundary")},
       {Act::ToolInside, Symbol::Inside, tr("Inside")},
       {Act::ToolOutside, Symbol::Outside, tr("Outside")},
       {Act::ToolBrush, Symbol::Brush, tr("Paint")},
       {Act::ToolEraser, Symbol::Eraser, tr("Erase")},
       {Act::ToolFreeze, Symbol::Freeze, tr("Freeze")}});
  auto* group = new QActionGroup(this);
  for (QAction* tool : bar->actions()) group->addAction(tool);
  for (QAction* tool : add_measure_button(*bar, *actions_)) group->addAction(tool);
  group->addAction((*actions_)[Act::ToolRange]);
  bar->addSeparator();
  auto* run = new QToolButton(bar);
  run->setObjectName("run");
  run->setDefaultAction((*actions_)[Act::RunPause]);
  run->setToolButtonStyle(Qt::ToolButtonTextUnderIcon);
  run->setIconSize(bar->iconSize());
  run->setMinimumWidth(64);
  bar->addWidget(run);
  bar->addWidget(new StateChip(*workbench_, *loop_, bar));
  add({{Act::Step, Symbol::Step, tr("Step")}, {Act::ResetPose, Symbol::Reset, tr("Reset")}});
  bar->addSeparator();
  add({{Act::Undo, Symbol::Undo, tr("Undo")}, {Act::Redo, Symbol::Redo, tr("Redo")}});
  bar->addSeparator();
  add({{Act::WindowLevel, Symbol::WindowLevel, tr("Contrast")},
       {Act::AutoContrast, Symbol::AutoContrast, tr("Automatic")},
       {Act::Fit, Symbol::Fit, tr("Fit")}});
  // Qt's own extension arrow has no contrast in the dark theme, and is only a few pixels wide.
  if (auto* more = bar->findChild<QToolButton*>("qt_toolbar_ext_button")) {
    auto* style = new WideExtensionStyle;
    style->setParent(bar);
    bar->setStyle(style);
    more->setStyle(style);
    more->setIcon(icon_of(Symbol::Menu));
    more->setToolTip(tr("Tools that do not fit into the toolbar"));
    more->setAccessibleName(tr("More tools"));
  }
}

void MainWindow::connect_own_actions() {
  ActionTable& actions = *actions_;
  actions.on(Act::Quit, [this] { close(); });
  actions.on(Act::Screenshot, [this] { choose_and_save_picture(); });
  actions.on(Act::Compare, [this] { compare_settings(); });
  actions.on(Act::Help, [this] { show_bindings(this); });
  actions.on(Act::ChangeKeys, [this] {
    auto* dialog = new KeyDialog(this);
    dialog->open();
  });
  actions.on_toggle(Act::ShowPanels, [this](bool shown) { panels_->setVisible(shown); });
  actions[Act::ShowPanels]->setChecked(true);
  actions.on_toggle(Act::ShowSteps, [this](bool shown) { steps_->setVisible(shown); });
  actions[Act::ShowSteps]->setChecked(true);
  actions.on(Act::Messages, [this] { messages_->show_log(); });
  actions.on(Act::About,
             [this] { show_about(this, QString::fromStdString(workbench_->session().engine().description())); });
}

void MainWindow::connect_messages() {
  connect(workbench_.get(), &Workbench::message, messages_, &MessageBar::show_message);
  connect(workbench_.get(), &Workbench::message_resolved, messages_, &MessageBar::dismiss);
  connect(workbench_.get(), &Workbench::acted, messages_, &MessageBar::dismiss_failure);
  connect(job_, &BackgroundJob::started, this,
          [this](const QString& title) { messages_->show_progress(title, job_->is_cancellable()); });
  connect(job_, &BackgroundJob::progressed, messages_, &MessageBar::set_fraction);
  connect(job_, &BackgroundJob::succeeded, messages_, &MessageBar::clear);
  connect(job_, &BackgroundJob::cancelled, messages_, &MessageBar::clear);
  connect(messages_, &MessageBar::cancel_requested, job_, &BackgroundJob::cancel);
  connect(job_, &BackgroundJob::failed, this,
          [this](const QString& why) { messages_->show_message(Severity::Failure, why); });
  connect(drawn_.get(), &DrawnScene::transfer_mode_changed, this, [this] {
    const SceneBuffers& buffers = drawn_->buffers();
    panels_->simulation().show_drawing(
        tr("%1; OpenGL renderer: %2")
            .arg(QString::fromStdString(buffers.transfer_mode()), QString::fromStdString(buffers.renderer())));
  });
}

// "[*]" is the place of the mark of unsaved changes.
void MainWindow::connect_title() {
  const auto mark = [this] { setWindowModified(workbench_->has_volume() && workbench_->has_unsaved_changes()); };
  for (const auto signal : {&Workbench::acted, &Workbench::pose_changed, &Workbench::volume_changed})
    connect(workbench_.get(), signal, this, mark);
  connect(files_, &FileActions::name_changed, this, [this, mark] {
    const QString name = files_->scene_name().replace("[*]", "[*][*]");  // the name itself may contain the mark
    setWindowTitle(name.isEmpty() ? "SimplexSeg[*]" : name + "[*] - SimplexSeg");
    mark();
  });
}

CompareWindow* MainWindow::compare_settings() {
  if (!workbench_->active_mesh()) return nullptr;
  workbench_->pause();
  try {
    auto* window = new CompareWindow(*workbench_, make_engine_, this);
    window->setAttribute(Qt::WA_DeleteOnClose);
    window->open();
    return window;
  } catch (const std::exception& error) {
    workbench_->notify(Severity::Failure, QString::fromUtf8(error.what()));
    return nullptr;
  }
}

QImage MainWindow::picture_of_views() {
  const bool was_shown = !messages_->isHidden();
  messages_->hide();  // the message bar covers the views
  QImage picture = views_->grab().toImage();
  messages_->setVisible(was_shown);
  return picture;
}

void MainWindow::save_picture(const QString& path) {
  QByteArray png;
  QBuffer buffer(&png);
  buffer.open(QIODevice::WriteOnly);
  grab().save(&buffer, "PNG");
  AtomicFile file(to_path(path));
  write_bytes(file, png.toStdString());
  file.commit();
}

void MainWindow::choose_and_save_picture() {
  ask_and_save(this, *workbench_,
               {tr("Save a picture of the window"), files_->suggested_path("", ".png"), tr("PNG (*.png)")},
               [this](const QString& path) { save_picture(path); });
}

void MainWindow::closeEvent(QCloseEvent* event) {
  if (!unattended_ && !files_->may_discard()) {
    event->ignore();
    return;
  }
  workbench_->pause();
  workbench_->cancel_field_update();  // the program would run until the field is solved
  event->accept();
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
  if (event->mimeData()->hasUrls()) event->acceptProposedAction();
}

void MainWindow::dropEvent(QDropEvent* event) {
  event->acceptProposedAction();
  const QStringList paths = FileActions::dropped_paths(event->mimeData());
  if (paths.isEmpty()) {
    workbench_->notify(Severity::Warning,
                       tr("The dropped item is not a file on this computer. Drop a local file or folder."));
  } else if (job_->busy()) {
    workbench_->notify(Severity::Warning, tr("Wait until loading or saving has finished"));
  } else {
    // Deferred: the question about unsaved changes would block the program from which the item was dragged.
    QMetaObject::invokeMethod(
        this, [this, paths] { files_->open_all(paths); }, Qt::QueuedConnection);
  }
}

}  // namespace simplexseg
