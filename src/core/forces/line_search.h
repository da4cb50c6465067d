// SPDX-License-Identifier: Apache-2.0
// What the image forces share: targets along the normal, and how they pull.
#pragma once
#include "core/sampling.h"
#include "core/step_view.h"

namespace simplexseg {

inline constexpr int kMaxSearch = 24;        ///< samples to each side
inline constexpr int kMaxProfile = 8;        ///< half length of a reference profile

/// Offset of the extremum of a parabola through (-1, a), (0, b), (1, c), b the largest; in [-1/2, 1/2].
SIMPLEXSEG_HD float parabolic_peak(float a, float b, float c) {
  const float curvature = a - 2.0f * b + c;
  if (!(curvature < 0.0f)) return 0.0f;
  const float t = 0.5f * (a - c) / curvature;
  return smaller(larger(t, -0.5f), 0.5f);
}

/// The force of a target held since the last refresh: its distance along the present normal, so that a vertex is free to
/// slide on the surface. `pull_mm` > 0 bounds it.
SIMPLEXSEG_HD Vec3 pull_to_target(Vec4 target, Vec3 p, Vec3 n, float pull_mm) {
  float d = dot(xyz(target) - p, n);
  if (pull_mm > 0.0f) d = smaller(larger(d, -pull_mm), pull_mm);
  return (target.w * d) * n;
}

}  // namespace simplexseg
