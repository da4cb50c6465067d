// SPDX-License-Identifier: Apache-2.0
#include "session/log_replay.h"

#include <algorithm>

#include "core/expect.h"

namespace simplexseg {

LogReplay::LogReplay(Session& session, const std::vector<LogEntry>& log, int trailing_steps)
    : session_(session), log_(log), trailing_steps_(trailing_steps) {
  // A recorded log contains the field updates and the comparisons that were made in the background. For a log written
  // by hand, changed fields are solved before the next step.
  is_recorded_ = std::any_of(log.begin(), log.end(), [](const LogEntry& entry) {
    return std::holds_alternative<StartFieldUpdate>(entry.command) ||
           std::holds_alternative<StartFieldComparison>(entry.command);
  });
  steps_left_ = log.empty() ? trailing_steps : log.front().steps;
}

/// Meshes whose comparison was started directly after the steps before the next command.
std::vector<ItemId> LogReplay::compared_next() const {
  std::vector<ItemId> meshes;
  for (std::size_t e = entry_; e < log_.size() && (e == entry_ || log_[e].steps == 0); ++e) {
    const auto* const start = std::get_if<StartFieldComparison>(&log_[e].command);
    if (!start) break;
    meshes.push_back(start->mesh);
  }
  return meshes;
}

Advance LogReplay::advance(int steps) {
  Advance done;
  const int count = std::min(steps, steps_left_);
  if (count > 0 && is_recorded_)
    done = session_.replay_steps(count, count == steps_left_ ? compared_next() : std::vector<ItemId>());
  else if (count > 0)
    done = session_.advance_steps(count);
  steps_left_ -= done.steps;
  return done;
}

void LogReplay::execute_next() {
  SIMPLEXSEG_EXPECT(steps_left_ == 0 && !done());
  if (entry_ < log_.size()) {
    const Command& command = log_[entry_].command;
    const auto* const start = std::get_if<StartFieldComparison>(&command);
    if (!start || !session_.is_comparing(start->mesh)) session_.apply(command);  // else started by the last step
  }
  ++entry_;
  steps_left_ = entry_ < log_.size() ? log_[entry_].steps : trailing_steps_;
}

void Session::replay(const std::vector<LogEntry>& log, int trailing_steps) {
  for (LogReplay replay(*this, log, trailing_steps); !replay.done(); replay.execute_next())
    while (replay.steps_left() > 0) replay.advance(replay.steps_left());
}

}  // namespace simplexseg
