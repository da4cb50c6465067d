// SPDX-License-Identifier: Apache-2.0
// What a step needs: the rules, once, for the engine that holds by them (src/gpu/step_engine.h) and for the plan that
// reports them (src/session/step_plan.cpp).
#pragma once
#include <algorithm>
#include <cstddef>
#include <span>

#include "forces/force_list.h"

namespace simplexseg {

/// Vertices whose motion is summed by one call of the motion kernel.
inline constexpr int kMotionBlock = 256;

/// What decides on the needs of one mesh.
struct MeshNeeds {
  ForceParameters forces;
  RecordedReferences recorded;
  bool finest = true;
  unsigned given = 0;  ///< forces whose targets are given, not searched for

  /// A force of weight 0, or whose reference was not taken (or no longer fits), does not act.
  bool acts(ForceId force) const {
    if (!(forces.weight(force) > 0.0f)) return false;
    bool has_reference = true;
    each_force([&]<class F>(F) {
      if constexpr (requires { F::has_reference(forces, recorded); })
        if (F::id == force && (given & bit(force)) == 0) has_reference = F::has_reference(forces, recorded);
    });
    return has_reference;
  }
};

struct StepNeeds {
  unsigned forces = 0;            ///< that some mesh uses; those that pull only where there is a point
  unsigned given = 0;             ///< of these, whose targets are given: for no mesh they are searched for
  int scratch[kForceCount] = {};  ///< floats that the search of a force keeps at hand
  bool local_statistics = false;
  bool fields = false, region_tables = false;  ///< where some mesh takes its evidence from
  int averaging_passes = 0;                    ///< of evidence targets
  int profile_stride = 0;                      ///< values of a reference profile
  int motion_sums = 0;
  int nearest_blocks = 0;  ///< of the largest mesh, for each attraction point
  bool operator==(const StepNeeds&) const = default;

  bool uses(ForceId force) const { return (forces & bit(force)) != 0; }
  /// Some force searches the volume for targets.
  bool searches() const { return (forces & ~given & kForcesWithTargets) != 0; }
  bool searches(ForceId force) const { return (forces & ~given & kForcesWithTargets & bit(force)) != 0; }
  bool averages() const { return averaging_passes > 0 || local_statistics; }
};

inline StepNeeds needs_of(std::span<const MeshNeeds> meshes, bool has_volume, int point_count) {
  StepNeeds needs;
  int largest = 0;
  for (const MeshNeeds& m : meshes) needs.given |= m.given;
  for (const MeshNeeds& m : meshes) {
    largest = std::max(largest, m.recorded.vertex_count);
    each_force([&]<class F>(F) {
      if (!m.acts(F::id)) return;
      needs.forces |= bit(F::id);
      if constexpr (HasTargets<F>) {
        if (!has_volume || (needs.given & bit(F::id)) != 0) return;
        int& scratch = needs.scratch[static_cast<int>(F::id)];
        scratch = std::max(scratch, F::scratch_floats(m.forces));
      }
    });
    // What single forces hold besides their targets.
    auto searches = [&](ForceId force) { return has_volume && m.acts(force) && (needs.given & bit(force)) == 0; };
    if (searches(IntensityProfileForce::id))
      needs.profile_stride = std::max(needs.profile_stride, IntensityProfileForce::profile_length(m.forces));
    if (searches(EvidenceForce::id)) {
      (EvidenceForce::from_field(m.forces) ? needs.fields : needs.region_tables) = true;
      needs.averaging_passes =
          std::max(needs.averaging_passes, m.forces.integer(EvidenceForce::id, EvidenceForce::averaging));
      needs.local_statistics = needs.local_statistics || (m.finest && EvidenceForce::compares_locally(m.forces));
    }
  }
  if (point_count == 0) needs.forces &= ~kPullingForces;
  if (!has_volume) needs.forces &= ~kImageForces | needs.given;
  needs.given &= needs.forces;
  needs.nearest_blocks = (largest + kNearestBlock - 1) / kNearestBlock;
  needs.motion_sums = static_cast<int>(meshes.size()) * ((largest + kMotionBlock - 1) / kMotionBlock);
  return needs;
}

}  // namespace simplexseg
