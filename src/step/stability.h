// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "core/vec3.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

/// Bounds of the eigenvalues of a mesh's linearised forces, including their weights.
struct Stiffness {
  float internal = 0;  ///< sum over the internal forces
  float image = 0;     ///< at a vertex whose targets have full confidence
  float external = 0;  ///< at a vertex that points attract
  float total() const { return internal + image + external; }
  float& of(ForceKind kind) {
    if (kind == ForceKind::Internal) return internal;
    return kind == ForceKind::Image ? image : external;
  }
};
/// Stiffness of the active forces. `shape`: reference of shape memory, whose metric parameters enter the bound.
Stiffness stiffness_of(const ForceParameters& forces, std::span<const Vec4> shape);
/// Bound of the largest eigenvalue of a mesh's linearised acceleration: sum_f k_f lambda_f over the active forces.
/// `shape`: as in stiffness_of().
float stiffness_bound(const ForceParameters& forces, std::span<const Vec4> shape);

/// Largest stable timestep of the damped Verlet scheme: dt^2 * stiffness < 4 - 2 damping (docs/mathematics.md, section
/// 3). Infinite if no force is active.
float stable_timestep(float stiffness, float damping);

/// Timestep in use: the selected one, limited to 90% of the bound unless limit_timestep is off.
float effective_timestep(const SimulationParameters& simulation, float stiffness);

}  // namespace simplexseg
