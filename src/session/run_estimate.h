// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>

#include "session/step_plan.h"

namespace simplexseg {

/// What a whole run of a scene on one CPU thread is likely to need, for a scheduler that wants to know before. An
/// estimate: it is fitted to runs that were measured (docs/cohort.md, "What is asked for").
struct RunEstimate {
  static constexpr const char* kSource =
      "an estimate, fitted to runs on one CPU thread (docs/cohort.md): about a third off in memory, a factor of two in "
      "time; far too low where a seed leaks";
  std::size_t process_bytes = 0;  ///< of the process: program, volume as it is read, engine at its finest, fields
  double seconds = 0;             ///< reading, learning fields, steps, writing
  std::int64_t steps = 0;         ///< that the seconds are for
};
/// `steps`: that are to be done; 0: until rest, of which the number is guessed.
RunEstimate estimate_run(const Scene& scene, const Volume& volume, const StepPlan& plan, int steps);

}  // namespace simplexseg
