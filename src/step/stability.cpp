// SPDX-License-Identifier: Apache-2.0
#include "step/stability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "forces/force_list.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

Stiffness stiffness_of(const ForceParameters& forces, std::span<const Vec4> shape) {
  Stiffness stiffness;
  each_force([&]<class F>(F) {
    float bound = 0;
    if constexpr (requires { F::stability_bound(forces, shape); })
      bound = F::stability_bound(forces, shape);
    else
      bound = F::stability_bound(forces);
    if (forces.weight(F::id) > 0.0f) stiffness.of(F::kind) += forces.weight(F::id) * bound;
  });
  return stiffness;
}

float stiffness_bound(const ForceParameters& forces, std::span<const Vec4> shape) {
  return stiffness_of(forces, shape).total();
}

float stable_timestep(float stiffness, float damping) {
  return stiffness > 0.0f ? std::sqrt((4.0f - 2.0f * damping) / stiffness) : std::numeric_limits<float>::infinity();
}

float effective_timestep(const SimulationParameters& s, float stiffness) {
  return s.limit_timestep > 0.5f ? std::min(s.timestep, 0.9f * stable_timestep(stiffness, s.damping)) : s.timestep;
}

}  // namespace simplexseg
