// SPDX-License-Identifier: Apache-2.0
#include "step/stability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "forces/force_list.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

Stiffness stiffness_of(const ForceParameters& p, std::span<const Vec4> shape) {
  float worst = 1.0f;
  for (const Vec4& s : shape) worst = std::max(worst, std::abs(s.x) + std::abs(s.y) + std::abs(1.0f - s.x - s.y));
  auto term = [&](ForceId force, float bound) { return p.weight(force) > 0.0f ? p.weight(force) * bound : 0.0f; };
  return {term(ForceId::Smoothing, SmoothingForce::stability_bound(p)) +
              term(ForceId::ShapeMemory, shape.empty() ? 0.0f : ShapeMemoryForce::stability_bound(worst)),
          term(ForceId::Gradient, GradientForce::stability_bound(p)) +
              term(ForceId::IntensityProfile, IntensityProfileForce::stability_bound(p)) +
              term(ForceId::Region, RegionForce::stability_bound(p)),
          term(ForceId::Attraction, AttractionForce::stability_bound(p))};
}

float stiffness_bound(const ForceParameters& p, std::span<const Vec4> shape) { return stiffness_of(p, shape).total(); }

float stable_timestep(float stiffness, float damping) {
  return stiffness > 0.0f ? std::sqrt((4.0f - 2.0f * damping) / stiffness) : std::numeric_limits<float>::infinity();
}

float effective_timestep(const SimulationParameters& s, float stiffness) {
  return s.limit_timestep > 0.5f ? std::min(s.timestep, 0.9f * stable_timestep(stiffness, s.damping)) : s.timestep;
}

}  // namespace simplexseg
