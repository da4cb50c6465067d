// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "session/plot.h"
#include "study/error_time.h"

namespace simplexseg {

/// All that was measured on one scene.
struct ErrorTimeResult {
  std::string name;  ///< of the scene
  std::string backend, device;
  int vertices = 0;  ///< of the frozen problem
  std::string how;   ///< FrozenProblem::how
  PoseError start_mm{};
  std::vector<FrozenCurve> frozen;
  std::vector<std::string> mesh_names;
  std::vector<LiveCurve> live;  ///< empty where the scene names no truth
};

/// scene, backend, method, solver, damping, timestep, steps, seconds, error, normal_error: a line for each sample.
std::string frozen_csv(const ErrorTimeResult& result);
/// scene, backend, solver, refresh_interval, start, mesh, steps, seconds, vertices, error_mean_mm, error_p95_mm,
/// error_max_mm, dice: a line for each sample.
std::string live_csv(const ErrorTimeResult& result);

/// Error of all methods against time, or against steps: the whole distance, or its part along the normals.
Plot frozen_plot(const ErrorTimeResult& result, bool against_steps, bool normal_part);
/// Mean surface error (of all meshes that have a truth) against time: every solver, with the middle refresh interval.
Plot live_plot(const ErrorTimeResult& result);
/// The same for one solver, the first, with every refresh interval.
Plot refresh_plot(const ErrorTimeResult& result);

/// A section of Markdown: time to 10%, 1% and 0.1%, with ratios to the baseline, and where the whole runs ended.
std::string markdown(const ErrorTimeResult& result);

}  // namespace simplexseg
