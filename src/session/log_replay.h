// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

#include "session/session.h"

namespace simplexseg {

/// Replay of a log on the current scene of a session, in parts of any number of steps.
class LogReplay {
 public:
  /// `trailing_steps`: number of steps after the last command. Session and log must outlive this object.
  LogReplay(Session& session, const std::vector<LogEntry>& log, int trailing_steps);

  bool done() const { return entry_ > log_.size(); }
  /// Number of commands executed so far.
  std::size_t commands_done() const { return std::min(entry_, log_.size()); }
  /// Number of steps before the next command.
  int steps_left() const { return steps_left_; }
  /// Runs up to `steps` of these steps; fewer after a failure, which does not end the replay.
  Advance advance(int steps);
  /// Executes the next command; after the trailing steps, ends the replay. No step may be left.
  void execute_next();

 private:
  std::vector<ItemId> compared_next() const;

  Session& session_;
  const std::vector<LogEntry>& log_;
  const int trailing_steps_;
  bool is_recorded_;
  std::size_t entry_ = 0;  ///< index of the next command; number of commands: the trailing steps
  int steps_left_;
};

}  // namespace simplexseg
