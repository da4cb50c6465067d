// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/frame_statistics.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/expect.h"

namespace simplexseg {

double FrameStatistics::now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void FrameStatistics::steps_done(int steps, double seconds) {
  if (steps <= 0) return;
  steps_since_shown_ += steps;
  if (record_) {
    record_->steps += steps;
    record_->step_seconds += seconds;
  }
  for (Move& move : moves_) move.stepped = true;
}

void FrameStatistics::point_moved(double since_s) {
  if (record_) moves_.push_back({since_s});
}

void FrameStatistics::painted() {
  image_pending_ = true;
  for (Move& move : moves_) {
    move.painted = true;
    move.painted_after_step = move.stepped;
  }
}

bool FrameStatistics::shown(double now_s) {
  if (!std::exchange(image_pending_, false)) return false;
  if (last_shown_s_) {
    const double interval_s = now_s - *last_shown_s_;
    const auto smooth = [](double& value, double sample) { value = value == 0 ? sample : 0.9 * value + 0.1 * sample; };
    smooth(interval_s_, interval_s);
    smooth(steps_per_frame_, steps_since_shown_);
    if (record_) record_->frame_s.push_back(interval_s);
  }
  last_shown_s_ = now_s;
  steps_since_shown_ = 0;
  for (Move& move : moves_) {
    if (move.painted && !std::exchange(move.shown, true)) record_->latency_s.push_back(now_s - move.since_s);
    if (move.painted_after_step) record_->response_s.push_back(now_s - move.since_s);
  }
  std::erase_if(moves_, [](const Move& move) { return move.painted_after_step; });
  return true;
}

void FrameStatistics::start_recording() { record_.emplace(), moves_.clear(); }
FrameStatistics::Record FrameStatistics::stop_recording() {
  moves_.clear();
  Record record = record_ ? std::move(*record_) : Record{};
  record_.reset();
  return record;
}

double percentile(std::vector<double> values, double share) {
  SIMPLEXSEG_EXPECT(share >= 0 && share <= 1);
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values[std::clamp<std::size_t>(rank, 1, values.size()) - 1];
}

}  // namespace simplexseg
