// SPDX-License-Identifier: Apache-2.0
// Rules that determine the arrays and kernels of a step, shared by the engine (src/gpu/step_engine.h) and the step
// plan, which reports the arrays and kernels to the user (src/session/step_plan.cpp).
#pragma once
#include <algorithm>
#include <cstddef>
#include <span>

#include "forces/force_list.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

/// Number of vertices whose motion is summed by one call of the motion kernel.
inline constexpr int kMotionBlock = 256;

/// Properties of one mesh that determine the arrays and kernels it needs.
struct MeshNeeds {
  ForceParameters forces;
  RecordedReferences recorded;
  bool finest = true;
  unsigned fixed_targets = 0;  ///< bits of the forces whose targets are fixed for this mesh

  /// True if a force is active: its weight is positive, and the reference that it needs, if any, exists and matches the
  /// mesh. A force with fixed targets needs no reference.
  bool acts(ForceId force) const {
    if (!(forces.weight(force) > 0.0f)) return false;
    bool has_reference = true;
    each_force([&]<class F>(F) {
      if constexpr (requires { F::has_reference(forces, recorded); })
        if (F::id == force && (fixed_targets & bit(force)) == 0) has_reference = F::has_reference(forces, recorded);
    });
    return has_reference;
  }
};

struct StepNeeds {
  unsigned forces = 0;            ///< bits of the forces that act on some mesh
  unsigned fixed_targets = 0;     ///< subset of `forces` with fixed targets on some mesh; searched for on no mesh
  int scratch[kForceCount] = {};  ///< scratch memory of each force's search for one vertex, floats
  bool local_statistics = false;  ///< true if the evidence force compares local statistics
  bool fields = false, region_tables = false;  ///< sources of evidence in use
  int averaging_passes = 0;                    ///< largest number of averaging passes over evidence targets
  int profile_stride = 0;                      ///< values per reference profile
  bool areas = false;                          ///< true if steps use areas and masses of the vertices
  int motion_sums = 0;                         ///< number of calls of the motion kernel
  int nearest_blocks = 0;                      ///< number of blocks of kNearestBlock vertices in the largest mesh
  bool operator==(const StepNeeds&) const = default;

  bool uses(ForceId force) const { return (forces & bit(force)) != 0; }
  /// True if any force searches the volume for targets; with an argument, if this force does.
  bool searches() const { return (forces & ~fixed_targets & kForcesWithTargets) != 0; }
  bool searches(ForceId force) const { return (forces & ~fixed_targets & kForcesWithTargets & bit(force)) != 0; }
  bool averages() const { return averaging_passes > 0 || local_statistics; }
};

inline StepNeeds needs_of(std::span<const MeshNeeds> meshes, const SimulationParameters& simulation, bool has_volume,
                          int point_count) {
  StepNeeds needs;
  needs.areas = simulation.uses_areas() && !meshes.empty();
  int largest = 0;
  for (const MeshNeeds& m : meshes) needs.fixed_targets |= m.fixed_targets;
  for (const MeshNeeds& m : meshes) {
    largest = std::max(largest, m.recorded.vertex_count);
    each_force([&]<class F>(F) {
      if (!m.acts(F::id)) return;
      needs.forces |= bit(F::id);
      if constexpr (HasTargets<F>) {
        if (!has_volume || (needs.fixed_targets & bit(F::id)) != 0) return;
        int& scratch = needs.scratch[static_cast<int>(F::id)];
        scratch = std::max(scratch, F::scratch_floats(m.forces));
      }
    });
    // Needs of individual forces in addition to their targets.
    auto searches = [&](ForceId force) {
      return has_volume && m.acts(force) && (needs.fixed_targets & bit(force)) == 0;
    };
    if (searches(IntensityProfileForce::id))
      needs.profile_stride = std::max(needs.profile_stride, IntensityProfileForce::profile_length(m.forces));
    if (searches(EvidenceForce::id)) {
      (EvidenceForce::from_field(m.forces) ? needs.fields : needs.region_tables) = true;
      needs.averaging_passes =
          std::max(needs.averaging_passes, m.forces.integer(EvidenceForce::id, EvidenceForce::averaging));
      needs.local_statistics = needs.local_statistics || (m.finest && EvidenceForce::has_local_evidence(m.forces));
    }
  }
  if (point_count == 0) needs.forces &= ~kPullingForces;
  if (!has_volume) needs.forces &= ~kImageForces | needs.fixed_targets;
  needs.fixed_targets &= needs.forces;
  needs.nearest_blocks = (largest + kNearestBlock - 1) / kNearestBlock;
  needs.motion_sums = static_cast<int>(meshes.size()) * ((largest + kMotionBlock - 1) / kMotionBlock);
  return needs;
}

}  // namespace simplexseg
