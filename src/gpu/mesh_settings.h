// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <span>

#include "forces/force_list.h"
#include "forces/step_view.h"
#include "step/stability.h"
#include "step/step_needs.h"

namespace simplexseg {

/// Index of the force with the largest weight.
inline int index_of_strongest(const ForceParameters& forces) {
  int force = 0;
  for (int f = 1; f < kForceCount; ++f)
    if (forces.values[f][0] > forces.values[force][0]) force = f;
  return force;
}

/// Sets the weight of inactive forces of a mesh to 0, and the constants that depend on the stiffness of the others.
/// `shape`: as in stiffness_of(); `voxel_mm`: smallest voxel spacing. Returns the stiffness bounds.
inline Stiffness set_active_forces(MeshConstants& c, const MeshNeeds& needs, std::span<const Vec4> shape,
                                   float voxel_mm) {
  for (const ForceInfo& force : force_list())
    if (!needs.acts(force.id)) c.forces.values[static_cast<int>(force.id)][0] = 0;
  const Stiffness stiffness = stiffness_of(c.forces, shape);
  c.stiffness = stiffness.internal;
  c.model = std::max(0.5f * stiffness.internal, 0.1f * (stiffness.image + stiffness.external));
  c.strongest = index_of_strongest(c.forces);
  c.voxel_mm = voxel_mm;
  return stiffness;
}

}  // namespace simplexseg
