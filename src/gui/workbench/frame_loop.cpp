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
// Largest duration of a frame: a hidden or covered window never reports that its image is on the screen.
constexpr int kLongestFrameMs = 50;
// Smallest duration of a frame: a higher frame rate is not visible, and the simulation uses the rest of the time.
constexpr double kShortestFrameS = 1.0 / 64;
}  // namespace

FrameLoop::FrameLoop(Workbench& workbench) : workbench_(workbench) {
  timer_.setSingleShot(true);
  timer_.setTimerType(Qt::PreciseTimer);
  connect(&timer_, &QTimer::timeout, this, &FrameLoop::tick);
  connect(&workbench_, &Workbench::running_changed, this, &FrameLoop::resume);
  connect(&workbench_, &Workbench::scene_changed, this, &FrameLoop::resume);
  connect(&workbench_, &Workbench::point_moved, this, &FrameLoop::on_point_moved);
  connect(&workbench_, &Workbench::advance_finished, this, &FrameLoop::on_advance_finished);
}

void FrameLoop::count(const Advance& done) {
  if (!std::exchange(counted_, true)) statistics_.steps_done(done.steps, done.seconds);
}

void FrameLoop::on_point_moved() {
  moved_ = true;
  if (workbench_.is_advancing()) count(workbench_.advance_result());  // these steps do not include the movement
  statistics_.point_moved(std::exchange(move_since_s_, std::nullopt).value_or(FrameStatistics::now_s()));
  resume();
}

void FrameLoop::resume() {
  settled_ = false, resumed_ = true;
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
  // A moved point is shown first: the device computes nothing else until its image is on the screen.
  if (moved_)
    begins_when_shown_ = true;
  else
    begin_concurrent();
}

void FrameLoop::begin_concurrent() {
  // In a nested event loop (a menu, a dialog) other code may hold references into the session.
  const bool nested = QThread::currentThread()->loopLevel() > 1 || QApplication::activeModalWidget();
  if (!timer_.isActive() || !workbench_.running() || !ticked_ || workbench_.is_advancing() || nested) return;
  // On the CPU the steps would compete with drawing.
  if (!concurrent_.value_or(std::strcmp(workbench_.session().engine().backend(), "cpu") != 0)) return;
  ticked_ = shown_ = finished_ = resumed_ = counted_ = false;
  const double budget_s = workbench_.scene().simulation.frame_budget_ms * 1e-3;
  workbench_.begin_advance(std::max(budget_s, kShortestFrameS - (FrameStatistics::now_s() - last_tick_s_)));
}

void FrameLoop::on_advance_finished() {
  finished_ = true;
  if (shown_ || !timer_.isActive()) tick();
}

void FrameLoop::view_shown() {
  const bool new_image = statistics_.shown(FrameStatistics::now_s());
  if (new_image) {
    moved_ = false;
    if (std::exchange(begins_when_shown_, false)) begin_concurrent();
  }
  if (!timer_.isActive()) {
    statistics_.interrupt();
  } else if (new_image && workbench_.is_advancing() && !finished_) {
    shown_ = true;  // the next frame starts when the steps are done
  } else if (new_image && timer_.remainingTime() > 0) {
    timer_.start(0);  // after the pending events, so that the frame includes the user's latest actions
  }
}

void FrameLoop::tick() {
  timer_.stop();
  Advance advance;
  if (workbench_.is_advancing()) {
    count(workbench_.advance_result());
    advance = workbench_.end_advance();
  } else if (workbench_.running()) {
    resumed_ = false;
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
  settled_ = advance.at_rest && !resumed_;
  if (!settled_ && !advance.failure) timer_.start(kLongestFrameMs);
  emit ticked();
}

}  // namespace simplexseg
