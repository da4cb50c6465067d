// SPDX-License-Identifier: Apache-2.0
// What the menu entries of the window do, save those of the files (file_actions.cpp).
#include <QAction>
#include <QCloseEvent>
#include <QCoreApplication>
#include <QDragEnterEvent>
#include <QDropEvent>
#include <QFileDialog>
#include <QGridLayout>
#include <QLabel>
#include <QMimeData>
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gui/input/action_table.h"
#include "gui/input/help.h"
#include "gui/panels/simulation_panel.h"
#include "gui/panels/widgets.h"
#include "gui/views/drawn_scene.h"
#include "gui/views/slice_view.h"
#include "gui/views/space_view.h"
#include "gui/window/file_actions.h"
#include "gui/window/main_window.h"
#include "gui/window/message_bar.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {
constexpr std::pair<Act, Tool> kTools[] = {{Act::ToolCrosshair, Tool::Crosshair},
                                           {Act::ToolZoomPan, Tool::ZoomPan},
                                           {Act::ToolPoint, Tool::Point},
                                           {Act::ToolSeed, Tool::Seed}};
}  // namespace

void MainWindow::connect_actions() {
  ActionTable& actions = *actions_;
  Workbench& bench = *workbench_;
  for (const auto& [act, tool] : kTools) {
    actions.on_toggle(act, [&bench, tool = tool](bool) {
      bench.view.tool = tool;
      bench.view.window_level_armed = false;
      bench.view_edited();
    });
  }
  actions[Act::ToolCrosshair]->setChecked(true);

  actions.on(Act::Quit, [this] { close(); });
  actions.on(Act::Screenshot, [this] { choose_and_save_picture(); });
  actions.on(Act::Undo, [&bench] { bench.apply(Undo{}); });
  actions.on(Act::Redo, [&bench] { bench.apply(Redo{}); });
  actions.on(Act::DeletePoint, [&bench] {
    const ItemId point = bench.view.hovered_point ? bench.view.hovered_point : bench.view.selected_point;
    if (point) bench.apply(DeleteAttractionPoint{point});
  });
  actions.on_toggle(Act::RunPause, [&bench](bool run) { run ? bench.run() : bench.pause(); });
  actions.on(Act::Step, [&bench] {
    bench.pause();
    bench.advance_steps(1);
  });
  actions.on(Act::ResetPose, [&bench] { bench.apply(ResetPose{0}); });

  const auto on_view_toggle = [&](Act act, bool ViewState::*member) {
    actions.on_toggle(act, [&bench, member](bool checked) {
      bench.view.*member = checked;
      bench.view_edited();
    });
    actions[act]->setChecked(bench.view.*member);
  };
  on_view_toggle(Act::ShowMeshes, &ViewState::show_meshes);
  on_view_toggle(Act::Annotations, &ViewState::show_annotations);
  on_view_toggle(Act::Slices3d, &ViewState::show_slices_3d);
  on_view_toggle(Act::WindowLevel, &ViewState::window_level_armed);
  // While W is held its repeats must not switch the mode off and on.
  actions[Act::WindowLevel]->setAutoRepeat(false);
  for (const Act act : {Act::RunPause, Act::ShowMeshes, Act::Annotations, Act::Slices3d})
    actions[act]->setAutoRepeat(false);
  actions.on_toggle(Act::Neurological, [&bench](bool checked) {
    bench.view.convention = checked ? Convention::Neurological : Convention::Radiological;
    bench.view_edited();
  });
  actions.on(Act::LessOpaque, [this] { change_opacity(-0.1f); });
  actions.on(Act::MoreOpaque, [this] { change_opacity(0.1f); });
  actions.on(Act::AutoContrast, [&bench] { bench.set_automatic_contrast(); });
  actions.on(Act::Fit, [this] {
    for (SliceView* view : slices_) view->fit();
    space_->fit();
  });
  actions.on(Act::CentreOnCursor, [this] {
    for (SliceView* view : slices_) view->centre_on_crosshair();
    space_->centre_on_crosshair();
  });
  actions.on(Act::Help, [this] { show_bindings(this); });
  actions.on(Act::About,
             [this] { show_about(this, QString::fromStdString(workbench_->session().engine().description())); });
}

void MainWindow::change_opacity(float by) {
  workbench_->view.opacity = std::clamp(workbench_->view.opacity + by, 0.1f, 1.0f);
  workbench_->view_edited();
}

void MainWindow::refresh_actions() {
  ActionTable& actions = *actions_;
  const Session& session = workbench_->session();
  const auto name_step = [](QAction* action, const QString& verb, const char* title) {
    action->setText(*title ? QString("%1 %2").arg(verb, QString::fromUtf8(title)) : verb);
    // The toolbar must not jump with every action.
    action->setIconText(QString(verb).remove('&'));
  };
  name_step(actions[Act::Undo], tr("&Undo"), session.undo_title());
  name_step(actions[Act::Redo], tr("&Redo"), session.redo_title());
  set_enabled(actions[Act::Undo], session.can_undo(), tr("There is nothing to undo"));
  set_enabled(actions[Act::Redo], session.can_redo(), tr("Nothing was undone"));
  const bool meshes = !workbench_->scene().meshes.empty();
  const QString no_mesh = tr("There is no mesh yet: add one in the panel Meshes, or with tool 4");
  for (const Act act : {Act::RunPause, Act::Step, Act::ResetPose}) set_enabled(actions[act], meshes, no_mesh);
  actions[Act::RunPause]->setText(workbench_->running() ? tr("&Pause") : tr("&Run"));
  actions[Act::RunPause]->setChecked(workbench_->running());
  actions[Act::ResetPose]->setIconText(tr("Reset"));
  actions[Act::AutoContrast]->setIconText(tr("Auto contrast"));
  set_enabled(actions[Act::DeletePoint], !workbench_->scene().points.empty(), tr("There is no point yet"));
  const QString no_volume = tr("Open a volume first");
  for (const Act act : {Act::ToolSeed, Act::AutoContrast, Act::Fit, Act::CentreOnCursor, Act::WindowLevel}) {
    set_enabled(actions[act], workbench_->has_volume(), no_volume);
  }
  set_enabled(actions[Act::ToolPoint], meshes, no_mesh);
}

void MainWindow::refresh_readout() {
  for (const auto& [act, tool] : kTools) (*actions_)[act]->setChecked(workbench_->view.tool == tool);
  (*actions_)[Act::WindowLevel]->setChecked(workbench_->view.window_level_armed);
  if (!workbench_->has_volume()) {
    readout_->setText(tr("No volume"));
    contrast_->clear();
    return;
  }
  const ViewState& view = workbench_->view;
  const Volume& volume = workbench_->session().volume();
  const Eigen::Vector3d index = volume.geometry().index_from_world() * view.crosshair_mm;
  int voxel[3];
  for (int axis = 0; axis < 3; ++axis) {
    voxel[axis] = std::clamp(static_cast<int>(std::lround(index[axis])), 0, volume.geometry().size[axis] - 1);
  }
  readout_->setText(tr("LPS  %1  %2  %3 mm      voxel  %4  %5  %6      intensity  %7")
                        .arg(view.crosshair_mm.x(), 0, 'f', 1)
                        .arg(view.crosshair_mm.y(), 0, 'f', 1)
                        .arg(view.crosshair_mm.z(), 0, 'f', 1)
                        .arg(voxel[0])
                        .arg(voxel[1])
                        .arg(voxel[2])
                        .arg(volume.value(voxel[0], voxel[1], voxel[2]), 0, 'g', 6));
  contrast_->setText(tr("window %1  level %2").arg(view.window, 0, 'g', 4).arg(view.level, 0, 'g', 4));
}

void MainWindow::refresh_drawing() {
  const SceneBuffers& buffers = drawn_->buffers();
  drawing_->setText(QString::fromStdString(buffers.renderer()) + ": " +
                    (buffers.on_device() ? tr("drawn on the device") : tr("uploaded each frame")));
  drawing_->setToolTip(QString::fromStdString(buffers.how()));
  simulation_->show_drawing(
      tr("%1; OpenGL by %2").arg(QString::fromStdString(buffers.how()), QString::fromStdString(buffers.renderer())));
}

void MainWindow::maximise(View* view) {
  maximised_ = maximised_ == view ? nullptr : view;
  View* const order[] = {slices_[0], slices_[1], slices_[2], space_};
  for (int n = 0; n < 4; ++n) {
    order[n]->setVisible(!maximised_ || order[n] == maximised_);
    // An empty row or column must take no room.
    const bool row_used = !maximised_ || maximised_ == order[2 * (n / 2)] || maximised_ == order[2 * (n / 2) + 1];
    const bool column_used = !maximised_ || maximised_ == order[n % 2] || maximised_ == order[n % 2 + 2];
    view_grid_->setRowStretch(n / 2, row_used);
    view_grid_->setColumnStretch(n % 2, column_used);
  }
}

void MainWindow::save_picture(const QString& path) {
  if (!grab().save(path, "PNG")) {
    throw Error(path.toStdString(), "the picture could not be written", "choose another file or folder");
  }
}

void MainWindow::choose_and_save_picture() {
  const QString path =
      QFileDialog::getSaveFileName(this, tr("Save a picture of the window"), "simplexseg.png", tr("PNG (*.png)"));
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
