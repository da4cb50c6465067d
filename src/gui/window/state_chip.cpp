// SPDX-License-Identifier: Apache-2.0
#include "gui/window/state_chip.h"

#include "gui/workbench/frame_loop.h"
#include "gui/workbench/run_state.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {

/// Background colour of a state; white text has a contrast of at least 4.5 on it.
const char* background_of(RunState state) {
  switch (state) {
    case RunState::Running:
    case RunState::Solving:
    case RunState::Waiting:
      return "#2b6ca3";
    case RunState::Settled:
      return "#2e6e4a";
    case RunState::Doubtful:
    case RunState::Spreading:
    case RunState::Pending:
    case RunState::Overlapping:
      return "#8a5a00";
    case RunState::Failed:
      return "#9b3030";
    case RunState::Nothing:
    case RunState::Paused:
    case RunState::Locked:
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
      tr("State: running; solving (a segmentation is computed from your points); marks pending (you cancelled that); "
         "settled; paused; probably wrong (mark more of what is inside and outside); spreading (a segmentation finds "
         "no border); overlaps itself (a surface does); locked; error"));
  setMinimumWidth(fontMetrics().horizontalAdvance(tr("no segmentation yet")) + 20);  // the toolbar must not move
  // Values that change with every frame are unreadable, so the text is refreshed four times a second.
  refresh_timer_.setSingleShot(true);
  refresh_timer_.setInterval(250);
  connect(&refresh_timer_, &QTimer::timeout, this, &StateChip::refresh);
  const auto soon = [this] {
    if (!workbench_.is_dragging() && run_state(workbench_, loop_) != state_) refresh();
    if (!refresh_timer_.isActive() && !workbench_.is_dragging()) refresh_timer_.start();
  };
  connect(&loop_, &FrameLoop::ticked, this, soon);
  connect(&workbench_, &Workbench::scene_changed, this, soon);
  connect(&workbench_, &Workbench::running_changed, this, soon);
  connect(&workbench_, &Workbench::solving_changed, this, soon);
  refresh();
}

void StateChip::refresh() {
  state_ = run_state(workbench_, loop_);
  setText(text_of(state_, workbench_.solving_percent()));
  setStyleSheet(
      QString("#state_chip { background: %1; color: white; border-radius: 9px; padding: 2px 8px; margin: 0 6px; }")
          .arg(background_of(state_)));
}

}  // namespace simplexseg
