// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "app/console.h"
#include "core/error.h"
#include "io/scene/log_io.h"
#include "io/scene/references.h"
#include "session/run_trace.h"
#include "session/session.h"

namespace simplexseg {

inline constexpr int kMaxStepsUntilRest = 100000;  ///< largest number of steps for scenes that never settle

/// Returns the time of a monotonic clock, s.
double seconds_now();

/// Calls `work` and converts each Error to a Failure (exit status 1), since the input is not the cause.
template <class Work>
auto as_failure(Work work) {
  try {
    return work();
  } catch (const Error& error) {
    throw Failure(error.what());
  }
}

/// Clock of a simulation that excludes the time for samples of the trace. `session` must outlive this object.
class TracedClock {
 public:
  /// Starts the clock and records the first sample. `references`: references for the surface error of the trace; null
  /// disables tracing.
  TracedClock(const Session& session, const References* references);

  /// Returns the time since construction, excluding the time for samples, s.
  double seconds() const { return seconds_now() - start_ - sampling_; }
  /// Returns the number of steps until the next sample, at most `steps`; without a trace, returns `steps`.
  int steps_until_sample(int steps) const;
  /// Records a sample if one is due.
  void sample_if_due();
  /// Records the last sample. Returns the value of seconds() before it, s.
  double stop();
  const RunTrace& trace() const { return trace_; }

 private:
  void sample(double seconds);

  const Session& session_;
  const bool traces_;
  RunTrace trace_;
  std::int64_t last_ = -1;  ///< step of the last sample
  double start_, sampling_ = 0;
};

/// Advances by `steps`; ends earlier after a failure or, if `until_rest` is true, when all meshes have settled. Runs in
/// chunks, which do not change the result, and checks for Ctrl+C between them. Throws Failure, also after Ctrl+C.
Advance simulate(Session& session, int steps, bool until_rest, TracedClock& clock, const Console& console);
/// Replays the steps and commands of a log like Session::replay(). Checks for Ctrl+C and then throws Failure.
Advance replay(Session& session, const LogFile& log, TracedClock& clock, const Console& console);

}  // namespace simplexseg
