// SPDX-License-Identifier: Apache-2.0
// Arrays and kernels that a step needs. The rules are shared by the engine (src/gpu/step_engine.h) and the plan that
// reports them (src/session/step_plan.cpp).
#pragma once
#include <algorithm>
#include <cstddef>
#include <span>

#include "forces/force_list.h"

namespace simplexseg {

/// Number of vertices whose motion is summed by one call of the motion kernel.
inline constexpr int kMotionBlock = 256;

/// Properties of one mesh that determine the arrays and kernels it needs.
struct MeshNeeds {
  ForceParameters forces;
  RecordedReferences recorded;
  bool finest = true;
  unsigned fixed_targets = 0;  ///< bits of the forces with fixed targets, which are not searched for

  /// True if a force is active: its weight is not 0, and its reference exists and matches the mesh.
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
  unsigned forces = 0;            ///< bits of the forces that are active on any mesh; pulling forces only with points
  unsigned fixed_targets = 0;     ///< subset of `forces` with fixed targets, which are not searched for on any mesh
  int scratch[kForceCount] = {};  ///< scratch floats of the search of each force
  bool local_statistics = false;
  bool fields = false, region_tables = false;  ///< sources of evidence in use
  int averaging_passes = 0;                    ///< averaging passes over evidence targets
  int profile_stride = 0;                      ///< values per reference profile
  int motion_sums = 0;
  int nearest_blocks = 0;  ///< blocks of the largest mesh, per attraction point
  bool operator==(const StepNeeds&) const = default;

  bool uses(ForceId force) const { return (forces & bit(force)) != 0; }
  /// True if some force searches the volume for targets.
  bool searches() const { return (forces & ~fixed_targets & kForcesWithTargets) != 0; }
  bool searches(ForceId force) const { return (forces & ~fixed_targets & kForcesWithTargets & bit(force)) != 0; }
  bool averages() const { return averaging_passes > 0 || local_statistics; }
};

inline StepNeeds needs_of(std::span<const MeshNeeds> meshes, bool has_volume, int point_count) {
  StepNeeds needs;
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
    // Arrays that single forces need in addition to their targets.
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
