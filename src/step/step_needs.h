// SPDX-License-Identifier: Apache-2.0
// What a step needs: the rules, once, for the engine that holds by them (src/gpu/step_engine.h) and for the plan that
// reports them (src/session/step_plan.cpp).
#pragma once
#include <algorithm>
#include <cstddef>
#include <span>

#include "forces/force_list.h"

namespace simplexseg {

/// Bits of a set of forces.
constexpr unsigned bit(ForceId force) { return 1u << static_cast<int>(force); }

/// Vertices whose motion is summed by one call of the motion kernel.
inline constexpr int kMotionBlock = 256;
/// How often local statistics are averaged over neighbours.
inline constexpr int kStatisticsPasses = 4;

/// What decides on the needs of one mesh.
struct MeshNeeds {
  ForceParameters forces;
  int vertex_count = 0;
  bool finest = true;
  bool has_shape = false;          ///< shape memory's reference was taken
  std::size_t profile_values = 0;  ///< of all recorded reference profiles of the mesh
  unsigned held = 0;               ///< forces whose targets are given, not searched for

  int profile_length() const {
    const auto& p = forces.values[static_cast<int>(ForceId::IntensityProfile)];
    return 2 * static_cast<int>(p[IntensityProfileForce::half_length] + 0.5f) + 1;
  }
  /// A force of weight 0, or whose reference was not taken (or no longer fits), does not act.
  bool acts(ForceId force) const {
    if (!(forces.weight(force) > 0.0f)) return false;
    if (force == ForceId::ShapeMemory) return has_shape;
    if (force == ForceId::IntensityProfile && (held & bit(force)) == 0)
      return profile_values == static_cast<std::size_t>(vertex_count) * profile_length();
    return true;
  }
};

struct StepNeeds {
  unsigned forces = 0;  ///< that some mesh uses; attraction only where there is a point
  unsigned held = 0;    ///< of these, whose targets are given: for no mesh they are searched for
  bool local_statistics = false;
  int averaging_passes = 0;  ///< of region targets
  int profile_stride = 0;    ///< values of a reference profile
  int gradient_scratch = 0, profile_scratch = 0,
      region_scratch = 0;  ///< floats that a search keeps at hand, some to spare
  int motion_sums = 0;
  int nearest_blocks = 0;  ///< of the largest mesh, for each attraction point
  bool operator==(const StepNeeds&) const = default;

  bool uses(ForceId force) const { return (forces & bit(force)) != 0; }
  bool searches() const {
    return searches(ForceId::Gradient) || searches(ForceId::IntensityProfile) || searches(ForceId::Region);
  }
  bool searches(ForceId force) const { return (forces & ~held & bit(force)) != 0; }
  bool averages() const { return averaging_passes > 0 || local_statistics; }
};

inline StepNeeds needs_of(std::span<const MeshNeeds> meshes, bool has_volume, int point_count) {
  StepNeeds needs;
  int largest = 0;
  for (const MeshNeeds& m : meshes) needs.held |= m.held;
  auto searches = [&](const MeshNeeds& m, ForceId force) { return m.acts(force) && (needs.held & bit(force)) == 0; };
  for (const MeshNeeds& m : meshes) {
    largest = std::max(largest, m.vertex_count);
    for (const ForceInfo& force : force_list())
      if (m.acts(force.id)) needs.forces |= bit(force.id);
    if (searches(m, ForceId::IntensityProfile)) {
      needs.profile_stride = std::max(needs.profile_stride, m.profile_length());
      const auto& profile = m.forces.values[static_cast<int>(ForceId::IntensityProfile)];
      const int reach = static_cast<int>(profile[IntensityProfileForce::samples] + 0.5f);
      needs.profile_scratch = std::max(needs.profile_scratch, 4 * reach + 1 + 2 * m.profile_length() + 8);
    }
    if (searches(m, ForceId::Gradient)) {
      const int reach =
          static_cast<int>(m.forces.values[static_cast<int>(ForceId::Gradient)][GradientForce::samples] + 0.5f);
      needs.gradient_scratch = std::max(needs.gradient_scratch, 4 * reach + 6);
    }
    if (!searches(m, ForceId::Region)) continue;
    const auto& region = m.forces.values[static_cast<int>(ForceId::Region)];
    needs.averaging_passes = std::max(needs.averaging_passes, static_cast<int>(region[RegionForce::averaging] + 0.5f));
    const int samples = 2 * static_cast<int>(region[RegionForce::samples] + 0.5f) + 1;
    needs.region_scratch = std::max(needs.region_scratch, 2 * samples);
    needs.local_statistics = needs.local_statistics || (m.finest && region[RegionForce::local] > 0.0f);
  }
  if (point_count == 0) needs.forces &= ~bit(ForceId::Attraction);
  if (!has_volume) {
    needs.forces &= ~(bit(ForceId::Gradient) | bit(ForceId::IntensityProfile) | bit(ForceId::Region)) | needs.held;
    needs.local_statistics = false, needs.averaging_passes = 0, needs.profile_stride = 0;
    needs.gradient_scratch = 0, needs.profile_scratch = 0, needs.region_scratch = 0;
  }
  needs.held &= needs.forces;
  needs.nearest_blocks = (largest + kNearestBlock - 1) / kNearestBlock;
  needs.motion_sums = static_cast<int>(meshes.size()) * ((largest + kMotionBlock - 1) / kMotionBlock);
  return needs;
}

}  // namespace simplexseg
