// SPDX-License-Identifier: Apache-2.0
#include "gui/frame_loop.h"

#include <chrono>

#include "gui/workbench.h"

namespace simplexseg {
namespace {
double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }
}  // namespace

FrameLoop::FrameLoop(Workbench& workbench) : workbench_(workbench) {
  // 60 frames a second where the machine can: the rest of a frame is for painting and input.
  timer_.setInterval(8);
  connect(&timer_, &QTimer::timeout, this, &FrameLoop::tick);
  connect(&workbench_, &Workbench::running_changed, this, &FrameLoop::wake);
  connect(&workbench_, &Workbench::scene_changed, this, &FrameLoop::wake);
}

void FrameLoop::wake() {
  at_rest_ = false;
  if (!workbench_.running() || workbench_.scene().meshes.empty()) {
    timer_.stop();
  } else if (!timer_.isActive()) {
    last_tick_s_ = now_s();
    timer_.start();
  }
  emit ticked();
}

void FrameLoop::tick() {
  if (!workbench_.running()) {
    timer_.stop();
    return;
  }
  const double budget_s = workbench_.scene().simulation.frame_budget_ms * 1e-3;
  const Advance advance = workbench_.advance(budget_s);
  const double now = now_s(), elapsed = now - last_tick_s_;
  last_tick_s_ = now;
  if (advance.steps > 0 && elapsed > 0) {
    const auto smooth = [](double& value, double sample) { value = value == 0 ? sample : 0.9 * value + 0.1 * sample; };
    smooth(steps_per_second_, advance.steps / elapsed);
    smooth(step_ms_, advance.seconds * 1e3 / advance.steps);
  }
  at_rest_ = advance.at_rest;
  if (at_rest_ || advance.failure) timer_.stop();
  emit ticked();
}

}  // namespace simplexseg
