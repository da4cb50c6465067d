// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "cli/commands.h"
#include "core/error.h"
#include "io/log_io.h"
#include "io/references.h"
#include "session/run_trace.h"
#include "session/session.h"

namespace simplexseg {

inline constexpr int kMostStepsUntilRest = 100000;  ///< where rest may never come

/// Monotonic, in seconds.
double seconds_now();

/// Whatever goes wrong in `work` is no fault of the input: exit status 1.
template <class Work>
auto as_failure(Work work) {
  try {
    return work();
  } catch (const Error& error) {
    throw Failure(error.what());
  }
}

/// The clock of a simulation, which stands still while a trace takes its samples.
class TracedClock {
 public:
  /// `references`: surface errors are traced; null: there is no trace, and nothing costs anything.
  TracedClock(const Session& session, const References* references);

  double seconds() const { return seconds_now() - start_ - sampling_; }
  /// Steps until the next sample; none: as many as one likes.
  int steps_until_sample(int steps) const;
  /// Takes a sample where one is due.
  void look();
  /// Takes the last sample. Returns the seconds that it is of.
  double stop();
  const RunTrace& trace() const { return trace_; }

 private:
  void sample(double seconds);

  const Session& session_;
  const bool traces_;
  RunTrace trace_;
  std::int64_t last_ = -1;
  double start_, sampling_ = 0;
};

/// Advances by the count of steps, or until rest; in chunks, so that Ctrl+C is heard. The chunks change no bit.
Advance simulate(Session& session, int steps, bool until_rest, TracedClock& clock, const Console& console);
/// The log's steps and commands, as Session::replay() does, with an ear for Ctrl+C.
Advance replay(Session& session, const LogFile& log, TracedClock& clock, const Console& console);

}  // namespace simplexseg
