// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "app/console.h"
#include "core/error.h"
#include "io/scene/log_io.h"
#include "io/scene/references.h"
#include "session/run_trace.h"
#include "session/session.h"

namespace simplexseg {

inline constexpr int kMaxStepsUntilRest = 100000;  ///< limit for scenes that never settle

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

/// Clock of a simulation that does not count the time for samples of the trace.
class TracedClock {
 public:
  /// `references`: references for the surface error of the trace; null disables tracing, at no cost.
  TracedClock(const Session& session, const References* references);

  /// Returns the time since construction without sampling, s.
  double seconds() const { return seconds_now() - start_ - sampling_; }
  /// Returns the steps until the next sample, at most `steps`; without a trace `steps`.
  int steps_until_sample(int steps) const;
  /// Records a sample if one is due.
  void sample_if_due();
  /// Records the last sample. Returns its time, s.
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

/// Advances by `steps`, or until the meshes settle. Runs in chunks and checks for Ctrl+C between them; the chunks
/// do not change the result.
Advance simulate(Session& session, int steps, bool until_rest, TracedClock& clock, const Console& console);
/// Replays the steps and commands of a log like Session::replay(), and checks for Ctrl+C.
Advance replay(Session& session, const LogFile& log, TracedClock& clock, const Console& console);

}  // namespace simplexseg
