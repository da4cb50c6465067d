// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/frame_loop.h"

#include <QApplication>
#include <QThread>
#include <algorithm>
#include <cstring>
#include <utility>

#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {
// A window that is hidden or covered shows nothing: the simulation goes on without it.
constexpr int kLongestFrameMs = 50;
// Nobody sees more pictures than this: what is left of a frame is the simulation's.
constexpr double kShortestFrameS = 1.0 / 64;
}  // namespace

FrameLoop::FrameLoop(Workbench& workbench) : workbench_(workbench) {
  timer_.setSingleShot(true);
  timer_.setTimerType(Qt::PreciseTimer);
  connect(&timer_, &QTimer::timeout, this, &FrameLoop::tick);
  connect(&workbench_, &Workbench::running_changed, this, &FrameLoop::wake);
  connect(&workbench_, &Workbench::scene_changed, this, &FrameLoop::wake);
  connect(&workbench_, &Workbench::point_moved, this, &FrameLoop::note_move);
  connect(&workbench_, &Workbench::advanced_beside, this, &FrameLoop::note_advanced);
}

void FrameLoop::count(const Advance& done) {
  if (!std::exchange(counted_, true)) statistics_.steps_done(done.steps, done.seconds);
}

void FrameLoop::note_move() {
  moved_ = true;
  if (workbench_.is_advancing()) count(workbench_.done_beside());  // which knew nothing of the movement
  statistics_.point_moved(std::exchange(move_since_s_, std::nullopt).value_or(FrameStatistics::now_s()));
  wake();
}

void FrameLoop::wake() {
  at_rest_ = false, woken_ = true;
  if (!workbench_.running() || workbench_.scene().meshes.empty()) {
    timer_.stop();
  } else if (!timer_.isActive()) {
    last_tick_s_ = FrameStatistics::now_s();
    statistics_.interrupt();
    timer_.start(0);
  }
  emit ticked();
}

void FrameLoop::view_composing() {
  // What the user moves is on its way to the screen: the device has nothing else to do until it is there.
  if (moved_)
    begins_when_shown_ = true;
  else
    begin_beside();
}

void FrameLoop::begin_beside() {
  // In a loop within a loop (a menu, a dialog) somebody may hold on to what belongs to the session.
  const bool nested = QThread::currentThread()->loopLevel() > 1 || QApplication::activeModalWidget();
  if (!timer_.isActive() || !workbench_.running() || !ticked_ || workbench_.is_advancing() || nested) return;
  // On the CPU it would take the processor from what draws.
  if (!beside_.value_or(std::strcmp(workbench_.session().engine().backend(), "cpu") != 0)) return;
  ticked_ = shown_ = ended_ = woken_ = counted_ = false;
  const double budget_s = workbench_.scene().simulation.frame_budget_ms * 1e-3;
  workbench_.begin_advance(std::max(budget_s, kShortestFrameS - (FrameStatistics::now_s() - last_tick_s_)));
}

void FrameLoop::note_advanced() {
  ended_ = true;
  if (shown_ || !timer_.isActive()) tick();
}

void FrameLoop::view_shown() {
  const bool new_picture = statistics_.shown(FrameStatistics::now_s());
  if (new_picture) {
    moved_ = false;
    if (std::exchange(begins_when_shown_, false)) begin_beside();
  }
  if (!timer_.isActive()) {
    statistics_.interrupt();
  } else if (new_picture && workbench_.is_advancing() && !ended_) {
    shown_ = true;  // the next frame begins when the steps are done
  } else if (new_picture && timer_.remainingTime() > 0) {
    timer_.start(0);  // after the events that wait: what the user did meanwhile is in this frame
  }
}

void FrameLoop::tick() {
  timer_.stop();
  Advance advance;
  if (workbench_.is_advancing()) {
    count(workbench_.done_beside());
    advance = workbench_.end_advance();
  } else if (workbench_.running()) {
    woken_ = false;
    advance = workbench_.advance(workbench_.scene().simulation.frame_budget_ms * 1e-3);
    statistics_.steps_done(advance.steps, advance.seconds);
  }
  if (!workbench_.running()) return;
  ticked_ = true;
  const double now = FrameStatistics::now_s(), elapsed = now - last_tick_s_;
  last_tick_s_ = now;
  if (advance.steps > 0 && elapsed > 0) {
    const auto smooth = [](double& value, double sample) { value = value == 0 ? sample : 0.9 * value + 0.1 * sample; };
    smooth(steps_per_second_, advance.steps / elapsed);
    smooth(step_ms_, advance.seconds * 1e3 / advance.steps);
  }
  at_rest_ = advance.at_rest && !woken_;
  if (!at_rest_ && !advance.failure) timer_.start(kLongestFrameMs);
  emit ticked();
}

}  // namespace simplexseg
