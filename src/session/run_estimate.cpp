// SPDX-License-Identifier: Apache-2.0
#include "session/run_estimate.h"

#include <algorithm>

#include "image/volume.h"
#include "session/mesh_life.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

// Fitted to what was measured (docs/results/cohort-2026-11-24.md).
constexpr double kProgramBytes = 40e6;
constexpr double kBytesOfVoxel = 5;         ///< besides the volume itself: labels, masks, the file as it is read
constexpr double kBytesOfFieldVoxel = 150;  ///< while a field is learned
constexpr double kBytesOfVertex = 1500;
constexpr double kSecondsOfVoxel = 40e-9;
constexpr double kSecondsOfFieldVoxel = 0.8e-6;
constexpr double kSecondsOfVertexStep = 80e-9;
constexpr int kStepsOfRest = 600;  ///< at the last level, until rest

}  // namespace

RunEstimate estimate_run(const Scene& scene, const Volume& volume, const StepPlan& plan, int steps) {
  double vertices = 0, most_field = 0, fields = 0;
  int levels = 1;
  for (const MeshItem& item : scene.meshes) {
    const int start = std::max(item.mesh.vertex_count(), 1);
    const int wanted =
        item.final_vertices > 0 ? item.final_vertices : static_cast<int>(scene.simulation.final_vertices);
    int of_mesh = 1;
    for (double n = start; n * 2 < wanted; n *= 4) ++of_mesh;
    levels = std::max(levels, of_mesh);
    vertices += std::max(start, wanted);
    if (!takes_field(item, volume)) continue;
    const auto voxels = static_cast<double>(expected_field_voxels(item, volume));
    fields += voxels;
    most_field = std::max(most_field, voxels);
  }
  const auto voxels = volume.empty() ? 0.0 : static_cast<double>(volume.geometry().voxel_count());
  RunEstimate estimate;
  estimate.steps = steps > 0 ? steps : static_cast<int>(scene.simulation.steps_per_level) * (levels - 1) + kStepsOfRest;
  estimate.process_bytes =
      static_cast<std::size_t>(kProgramBytes + static_cast<double>(plan.bytes_held()) + kBytesOfVoxel * voxels +
                               kBytesOfFieldVoxel * most_field + kBytesOfVertex * vertices);
  estimate.seconds = kSecondsOfVoxel * voxels + kSecondsOfFieldVoxel * fields +
                     kSecondsOfVertexStep * vertices * static_cast<double>(estimate.steps);
  return estimate;
}

}  // namespace simplexseg
