// SPDX-License-Identifier: Apache-2.0
#include "gui/window/state_chip.h"

#include "gui/workbench/frame_loop.h"
#include "gui/workbench/run_state.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {

/// Text in white has a contrast of 4.5 or more on each.
const char* background_of(RunState state) {
  switch (state) {
    case RunState::Running:
    case RunState::Learning:
      return "#2b6ca3";
    case RunState::AtRest:
      return "#2e6e4a";
    case RunState::Unsure:
    case RunState::Leaking:
      return "#8a5a00";
    case RunState::Failed:
      return "#9b3030";
    case RunState::Nothing:
    case RunState::Paused:
      break;
  }
  return "#4a4f58";
}

}  // namespace

StateChip::StateChip(Workbench& workbench, FrameLoop& loop, QWidget* parent)
    : QLabel(parent), workbench_(workbench), loop_(loop), state_(run_state(workbench, loop)) {
  setObjectName("state_chip");
  setAlignment(Qt::AlignCenter);
  setFixedHeight(fontMetrics().height() + 8);
  setAccessibleName(tr("State of the simulation"));
  setToolTip(
      tr("What the simulation does: running, learning (a mesh waits for what is learned from its marks), at rest, "
         "paused, unsure (little of a mesh is likely to be right), leaking (a mesh finds no end of its object), "
         "error"));
  setMinimumWidth(fontMetrics().horizontalAdvance(tr("running, 00000 steps/s")) + 20);  // it must not jump
  // Numbers that change with every frame cannot be read.
  calm_.setSingleShot(true);
  calm_.setInterval(250);
  connect(&calm_, &QTimer::timeout, this, &StateChip::refresh);
  const auto soon = [this] {
    if (run_state(workbench_, loop_) != state_) refresh();
    if (!calm_.isActive() && !workbench_.is_dragging()) calm_.start();
  };
  connect(&loop_, &FrameLoop::ticked, this, soon);
  connect(&workbench_, &Workbench::scene_changed, this, soon);
  connect(&workbench_, &Workbench::running_changed, this, soon);
  connect(&workbench_, &Workbench::learning_changed, this, soon);
  refresh();
}

void StateChip::refresh() {
  state_ = run_state(workbench_, loop_);
  setText(text_of(state_, loop_));
  setStyleSheet(
      QString("#state_chip { background: %1; color: white; border-radius: 9px; padding: 2px 8px; margin: 0 6px; }")
          .arg(background_of(state_)));
}

}  // namespace simplexseg
