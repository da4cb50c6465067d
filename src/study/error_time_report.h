// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "session/plot.h"
#include "study/error_time.h"

namespace simplexseg {

/// All measurements on one scene.
struct ErrorTimeResult {
  std::string name;  ///< name of the scene
  std::string backend, device;
  int vertices = 0;  ///< number of vertices of the frozen problem
  std::string how;   ///< method and accuracy of the fixed point (FrozenProblem::how)
  PoseError start_mm{};
  std::vector<FrozenCurve> frozen;
  std::vector<std::string> mesh_names;
  std::vector<LiveCurve> live;  ///< empty if the scene has no reference
};

/// CSV with a line per sample: scene, backend, method, solver, damping, timestep, steps, seconds, error, normal_error.
std::string frozen_csv(const ErrorTimeResult& result);
/// CSV with a line per sample: scene, backend, solver, refresh_interval, start, mesh, steps, seconds, vertices,
/// error_mean_mm, error_p95_mm, error_max_mm, dice.
std::string live_csv(const ErrorTimeResult& result);

/// Plot of the error of all methods. `against_steps`: against steps instead of time; `normal_part`: error along the
/// normals instead of the whole error.
Plot frozen_plot(const ErrorTimeResult& result, bool against_steps, bool normal_part);
/// Plot of the mean surface error against time, averaged over the meshes with a reference, for all solvers with a
/// refresh interval of 3 steps.
Plot live_plot(const ErrorTimeResult& result);
/// Plot of the mean surface error against time, averaged over the meshes with a reference, for the first solver with
/// every refresh interval.
Plot refresh_plot(const ErrorTimeResult& result);

/// Markdown section: steps and time to 10%, 1% and 0.1% of the initial error, ratios to the baseline, and results of
/// the complete runs.
std::string markdown(const ErrorTimeResult& result);

}  // namespace simplexseg
