// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/simulation_panel.h"

#include <QAction>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QLocale>
#include <QTimer>
#include <QToolButton>
#include <QVBoxLayout>
#include <algorithm>

#include "gui/input/action_table.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/panels/simulation_rows.h"
#include "gui/workbench/frame_loop.h"
#include "gui/workbench/run_state.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

SimulationPanel::SimulationPanel(Workbench& workbench, FrameLoop& loop, ActionTable& actions, QWidget* parent)
    : QWidget(parent), workbench_(workbench), loop_(loop) {
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(8, 6, 4, 4);
  auto* buttons = new QHBoxLayout;
  for (const Act act : {Act::RunPause, Act::Step, Act::ResetPose}) {
    auto* button = new QToolButton(this);
    button->setDefaultAction(actions[act]);
    button->setToolButtonStyle(Qt::ToolButtonTextOnly);
    button->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
    set_role(button, "raised");
    buttons->addWidget(button);
  }
  layout->addLayout(buttons);

  auto* status = new QFormLayout;
  status->setVerticalSpacing(2);
  status->setHorizontalSpacing(12);
  const auto add_status = [&](const QString& title, QLabel*& value) {
    value = new QLabel(this);
    value->setTextInteractionFlags(Qt::TextSelectableByMouse);
    auto* label = new QLabel(title, this);
    set_role(label, "dim");
    status->addRow(label, value);
  };
  add_status(tr("Speed"), speed_);
  add_status(tr("Frames"), frames_);
  add_status(tr("Vertices"), vertices_);
  add_status(tr("Motion"), motion_);
  add_status(tr("Surface"), surface_);
  add_status(tr("Backend"), backend_);
  surface_->setWordWrap(true);
  surface_->setToolTip(
      tr("The surface overlaps itself where the normals of neighbouring vertices differ by more than 90 degrees"));
  backend_->setWordWrap(true);
  frames_->setToolTip(tr("Frames per second, and simulation steps per frame"));
  layout->addLayout(status);

  rows_ = new SimulationRows(workbench_, this);
  layout->addWidget(rows_, 1);

  connect(&workbench_, &Workbench::scene_changed, this, &SimulationPanel::refresh_status);
  connect(&workbench_, &Workbench::running_changed, this, &SimulationPanel::refresh_status);
  // Values that change with every frame are unreadable, so the values are refreshed five times a second.
  auto* timer = new QTimer(this);
  timer->setInterval(200);
  connect(timer, &QTimer::timeout, this, [this] {
    if (workbench_.running() && !workbench_.is_dragging()) refresh_status();
  });
  timer->start();
  refresh_status();
}

ParameterRow* SimulationPanel::row(int parameter) const { return rows_->row(parameter); }

void SimulationPanel::show_drawing(const QString& how) {
  drawing_ = how;
  refresh_status();
}

QStringList SimulationPanel::faulty_surfaces() const {
  QStringList faulty;
  const std::vector<MeshItem>& meshes = workbench_.scene().meshes;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const QString faults = faults_of(workbench_, m);
    if (faults.isEmpty()) continue;
    const QString name = meshes.size() > 1 ? QString::fromStdString(meshes[m].name) + ": " : QString();
    faulty << name + faults;
  }
  return faulty;
}

void SimulationPanel::refresh_surface(const QStringList& faulty) {
  const bool known = workbench_.session().total_steps() > 0 && !workbench_.scene().meshes.empty();
  if (!known) {
    surface_->setText(tr("not run yet"));
  } else if (faulty.isEmpty()) {
    surface_->setText(tr("no self-overlap"));
  } else {
    surface_->setText(faulty.join("; "));
  }
  set_role(surface_, known && !faulty.isEmpty() ? "warning" : "");
}

void SimulationPanel::refresh_status() {
  const QLocale locale = QLocale::c();
  if (loop_.step_ms() > 0) {
    speed_->setText(
        tr("%1 steps/s, %2 ms per step").arg(loop_.steps_per_second(), 0, 'f', 0).arg(loop_.step_ms(), 0, 'g', 3));
  } else {
    speed_->setText(tr("not run yet"));
  }
  const FrameStatistics& statistics = loop_.statistics();
  frames_->setText(statistics.frames_per_second() > 0 ? tr("%1 per second, %2 steps per frame")
                                                            .arg(statistics.frames_per_second(), 0, 'f', 0)
                                                            .arg(statistics.steps_per_frame(), 0, 'f', 1)
                                                      : tr("none yet"));
  qint64 vertices = 0;
  for (const MeshItem& item : workbench_.scene().meshes) vertices += item.mesh.vertex_count();
  vertices_->setText(
      tr("%1 in %2")
          .arg(locale.toString(vertices),
               counted_text(static_cast<std::int64_t>(workbench_.scene().meshes.size()), "segmentation")));
  const std::vector<float>& moves = workbench_.session().mean_move_mm();
  const QStringList faulty = faulty_surfaces();
  const QString state = text_of(run_state(workbench_, loop_), workbench_.solving_percent());
  if (moves.empty() || workbench_.session().total_steps() == 0) {
    motion_->setText(state);
  } else {
    motion_->setText(tr("%1 mm per step, %2").arg(*std::max_element(moves.begin(), moves.end()), 0, 'g', 2).arg(state));
  }
  refresh_surface(faulty);
  QString backend = QString::fromStdString(workbench_.session().engine().description());
  if (!drawing_.isEmpty()) backend += "; " + drawing_;
  backend_->setText(backend);
}

}  // namespace simplexseg
