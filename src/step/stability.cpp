// SPDX-License-Identifier: Apache-2.0
#include "step/stability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "forces/force_list.h"
#include "forces/step_view.h"
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

float acceleration_bound(const SimulationParameters& s) {
  if (!s.uses_areas()) return 1;
  // (1 + f (a - 1)) / (1 + m (a - 1)) is monotonic in the relative area a, so its maximum lies at an end of the range.
  const auto factor = [&](float a) { return (1 + s.area_in_force * (a - 1)) / (1 + s.area_in_mass * (a - 1)); };
  return std::max(factor(kMinRelativeArea), factor(kMaxRelativeArea));
}

float effective_timestep(const SimulationParameters& s, float stiffness) {
  return s.limit_timestep > 0.5f
             ? std::min(s.timestep, 0.9f * stable_timestep(stiffness * acceleration_bound(s), s.damping))
             : s.timestep;
}

}  // namespace simplexseg
