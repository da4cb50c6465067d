// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <span>

#include "forces/force_list.h"
#include "forces/step_view.h"
#include "step/stability.h"
#include "step/step_needs.h"

namespace simplexseg {

/// The index of the force of the largest weight.
inline int strongest_of(const ForceParameters& forces) {
  int force = 0;
  for (int f = 1; f < kForceCount; ++f)
    if (forces.values[f][0] > forces.values[force][0]) force = f;
  return force;
}

/// Tells a mesh which forces act on it, those of `needs`, and how strong they are; `shape` as in stiffness_of().
/// Returns the bounds of its stiffness.
inline Stiffness tell_forces(MeshConstants& c, const MeshNeeds& needs, std::span<const Vec4> shape, float voxel_mm) {
  for (const ForceInfo& force : force_list())
    if (!needs.acts(force.id)) c.forces.values[static_cast<int>(force.id)][0] = 0;
  const Stiffness stiffness = stiffness_of(c.forces, shape);
  c.stiffness = stiffness.internal;
  c.model = std::max(0.5f * stiffness.internal, 0.1f * (stiffness.image + stiffness.external));
  c.strongest = strongest_of(c.forces);
  c.voxel_mm = voxel_mm;
  return stiffness;
}

}  // namespace simplexseg
