// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "core/vec3.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

/// Upper bounds of the eigenvalues of the linearised forces of a mesh, multiplied by the weights of the forces.
struct Stiffness {
  float internal = 0;  ///< sum over the internal forces
  float image = 0;     ///< sum over the image forces, at a vertex whose targets have confidence 1
  float external = 0;  ///< sum over the external forces, at a vertex that is attracted by points
  float total() const { return internal + image + external; }
  float& of(ForceKind kind) {
    if (kind == ForceKind::Internal) return internal;
    return kind == ForceKind::Image ? image : external;
  }
};
/// Stiffness of the forces with a positive weight. `shape`: reference of shape memory, one entry per vertex, from which
/// the bound of this force is computed; may be empty.
Stiffness stiffness_of(const ForceParameters& forces, std::span<const Vec4> shape);
/// Upper bound of the eigenvalues of the linearised acceleration of a mesh: sum_f k_f lambda_f over the forces with a
/// positive weight k_f; lambda_f: bound of force f. `shape`: as in stiffness_of().
float stiffness_bound(const ForceParameters& forces, std::span<const Vec4> shape);

/// Upper bound of the stable timesteps dt of the damped Verlet scheme: dt^2 * stiffness < 4 - 2 damping
/// (docs/mathematics.md, section 3). Infinite if `stiffness` is 0.
float stable_timestep(float stiffness, float damping);

/// Upper bound of the factor by which areas and masses increase the acceleration of a vertex: 1 without them
/// (docs/mathematics.md, section 3).
float acceleration_bound(const SimulationParameters& simulation);

/// Timestep of the verlet solver: the selected one, limited to 90% of stable_timestep() unless limit_timestep is off.
/// Includes acceleration_bound().
float effective_timestep(const SimulationParameters& simulation, float stiffness);

}  // namespace simplexseg
