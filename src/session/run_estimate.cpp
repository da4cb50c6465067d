// SPDX-License-Identifier: Apache-2.0
#include "session/run_estimate.h"

#include <algorithm>

#include "field/field_memory.h"
#include "image/volume.h"
#include "session/mesh_lifecycle.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

// Fitted to measured runs (docs/results/archive/cohort-2026-11-24.md).
constexpr double kProgramBytes = 40e6;
constexpr double kBytesPerVoxel = 5;  ///< memory in addition to the volume: labels, masks, buffers of the reader
constexpr double kBytesPerVertex = 1500;
constexpr double kSecondsPerVoxel = 40e-9;
constexpr double kSecondsPerFieldCell = 0.8e-6;
constexpr double kSecondsPerVertexStep = 80e-9;
constexpr int kLastLevelSteps = 600;  ///< assumed number of steps on the finest level until all meshes have settled

}  // namespace

RunEstimate estimate_run(const Scene& scene, const Volume& volume, const StepPlan& plan, int steps) {
  RunEstimate estimate;
  double vertices = 0;
  int levels = 1;
  for (const MeshItem& item : scene.meshes) {
    const int start = std::max(item.mesh.vertex_count(), 1);
    const int final_vertices =
        item.final_vertices > 0 ? item.final_vertices : static_cast<int>(scene.simulation.final_vertices);
    int mesh_levels = 1;
    for (double n = start; n * 2 < final_vertices; n *= 4) ++mesh_levels;
    levels = std::max(levels, mesh_levels);
    vertices += std::max(start, final_vertices);
    if (!uses_field(item, volume)) continue;
    const std::size_t cells = expected_field_cells(item, volume);
    const FieldMemory memory = expected_field_memory(cells);
    estimate.field_cells += cells;
    estimate.field_bytes_held += memory.held;
    estimate.field_bytes_solving = std::max(estimate.field_bytes_solving, memory.solving);
  }
  const auto voxels = volume.empty() ? 0.0 : static_cast<double>(volume.geometry().voxel_count());
  estimate.steps =
      steps > 0 ? steps : static_cast<int>(scene.simulation.steps_per_level) * (levels - 1) + kLastLevelSteps;
  estimate.process_bytes =
      plan.bytes_allocated() + estimate.field_bytes_held + estimate.field_bytes_solving +
      static_cast<std::size_t>(kProgramBytes + kBytesPerVoxel * voxels + kBytesPerVertex * vertices);
  estimate.seconds = kSecondsPerVoxel * voxels + kSecondsPerFieldCell * static_cast<double>(estimate.field_cells) +
                     kSecondsPerVertexStep * vertices * static_cast<double>(estimate.steps);
  return estimate;
}

}  // namespace simplexseg
