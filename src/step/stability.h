// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "core/vec3.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

/// Bounds of the eigenvalues of a mesh's linearised forces, weights included.
struct Stiffness {
  float internal = 0;  ///< what the forces of this kind add up to
  float image = 0;     ///< at a vertex whose targets are all trusted
  float external = 0;  ///< at a vertex that points pull
  float total() const { return internal + image + external; }
  float& of(ForceKind kind) {
    if (kind == ForceKind::Internal) return internal;
    return kind == ForceKind::Image ? image : external;
  }
};
/// As the forces that act report it. `shape` is shape memory's reference (its metric parameters enter the bound).
Stiffness stiffness_of(const ForceParameters& forces, std::span<const Vec4> shape);
/// sum_f k_f lambda_f over the active forces: the largest eigenvalue of a mesh's linearised acceleration, as its forces
/// report it. `shape` is shape memory's reference (its metric parameters enter the bound).
float stiffness_bound(const ForceParameters& forces, std::span<const Vec4> shape);

/// Largest stable timestep of the damped Verlet scheme: dt^2 * stiffness < 4 - 2 damping (docs/mathematics.md, section
/// 3). Infinite when no force acts.
float stable_timestep(float stiffness, float damping);

/// The timestep that is used: the wanted one, cut to 90% of the bound unless limit_timestep is off.
float effective_timestep(const SimulationParameters& simulation, float stiffness);

}  // namespace simplexseg
