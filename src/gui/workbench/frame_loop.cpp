// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/frame_loop.h"

#include <utility>

#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {
// A window that is hidden or covered shows nothing: the simulation goes on without it.
constexpr int kLongestFrameMs = 50;
}  // namespace

FrameLoop::FrameLoop(Workbench& workbench) : workbench_(workbench) {
  timer_.setSingleShot(true);
  timer_.setTimerType(Qt::PreciseTimer);
  connect(&timer_, &QTimer::timeout, this, &FrameLoop::tick);
  connect(&workbench_, &Workbench::running_changed, this, &FrameLoop::wake);
  connect(&workbench_, &Workbench::scene_changed, this, &FrameLoop::wake);
  connect(&workbench_, &Workbench::point_moved, this, &FrameLoop::note_move);
}

void FrameLoop::note_move() {
  statistics_.point_moved(std::exchange(move_since_s_, std::nullopt).value_or(FrameStatistics::now_s()));
  wake();
}

void FrameLoop::wake() {
  at_rest_ = false;
  if (!workbench_.running() || workbench_.scene().meshes.empty()) {
    timer_.stop();
  } else if (!timer_.isActive()) {
    last_tick_s_ = FrameStatistics::now_s();
    statistics_.interrupt();
    timer_.start(0);
  }
  emit ticked();
}

void FrameLoop::view_shown() {
  const bool new_picture = statistics_.shown(FrameStatistics::now_s());
  if (!timer_.isActive()) {
    statistics_.interrupt();
  } else if (new_picture && timer_.remainingTime() > 0) {
    timer_.start(0);  // after the events that wait: what the user did meanwhile is in this frame
  }
}

void FrameLoop::tick() {
  timer_.stop();
  if (!workbench_.running()) return;
  const double budget_s = workbench_.scene().simulation.frame_budget_ms * 1e-3;
  const Advance advance = workbench_.advance(budget_s);
  const double now = FrameStatistics::now_s(), elapsed = now - last_tick_s_;
  last_tick_s_ = now;
  statistics_.steps_done(advance.steps, advance.seconds);
  if (advance.steps > 0 && elapsed > 0) {
    const auto smooth = [](double& value, double sample) { value = value == 0 ? sample : 0.9 * value + 0.1 * sample; };
    smooth(steps_per_second_, advance.steps / elapsed);
    smooth(step_ms_, advance.seconds * 1e3 / advance.steps);
  }
  at_rest_ = advance.at_rest;
  if (!at_rest_ && !advance.failure) timer_.start(kLongestFrameMs);
  emit ticked();
}

}  // namespace simplexseg
