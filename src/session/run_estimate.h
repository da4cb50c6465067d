// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>

#include "session/step_plan.h"

namespace simplexseg {

/// Estimated memory and time of a run of a scene on one CPU thread, for the resource requests of schedulers; fitted to
/// measured runs (docs/cohort.md).
struct RunEstimate {
  static constexpr const char* kSource =
      "an estimate, fitted to runs on one CPU thread (docs/cohort.md): within about a third in memory and a factor of "
      "two in time; far too low where a segmentation spreads without a border";
  std::size_t process_bytes = 0;     ///< memory of program, volume while it is read, engine on the finest level, fields
  std::size_t field_cells = 0;       ///< cells of all fields
  std::size_t field_bytes_held = 0;  ///< memory of the solvers of all fields between updates
  std::size_t field_bytes_solving = 0;  ///< in addition, while the largest field is solved
  double seconds = 0;                   ///< time for reading, solving fields, steps and writing
  std::int64_t steps = 0;               ///< number of steps that `seconds` assumes
};
/// Estimates a run of `steps` steps; 0: until all meshes settle, with an assumed number of steps. `plan`: plan of the
/// scene.
RunEstimate estimate_run(const Scene& scene, const Volume& volume, const StepPlan& plan, int steps);

}  // namespace simplexseg
