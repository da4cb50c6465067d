// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "forces/step_view.h"

namespace simplexseg {

/// Draws each vertex to the middle of its neighbours, along the surface:
///   t = (P1 + P2 + P3)/3 - P,   d = t - (1 - lift)(t . n) n
struct CentringForce {
  static constexpr ForceId id = ForceId::Centring;
  static constexpr ForceKind kind = ForceKind::Internal;
  static constexpr const char* name = "centring";   // in scene files, logs and on the command line
  static constexpr const char* title = "Centring";  // in the panel
  static constexpr const char* doc = "Draws each vertex to the middle of its neighbours, along the surface.";
  enum Parameter : int { weight, lift, parameter_count };
  static constexpr ParameterInfo parameters[] = {
      {"weight", 0, 0, 10, "", "Strength of the force; 0 leaves it out."},
      {"lift", 0, 0, 1, "", "Share of the motion along the normal that is kept; 1 is a plain Laplacian."},
  };
  /// Bound of the largest eigenvalue of -d(displacement)/dx: a Laplacian with equal weights, or less.
  static constexpr float stability_bound(const ForceParameters&) { return 2.0f; }

  SIMPLEXSEG_HD static Vec3 displacement(const StepView& v, const MeshConstants& m, int, Int4 nb, Vec3 p, Vec4 frame) {
    const Vec3 sum = (xyz(v.current[nb.x]) - p) + (xyz(v.current[nb.y]) - p) + (xyz(v.current[nb.z]) - p);
    const Vec3 t = (1.0f / 3.0f) * sum, n = xyz(frame);
    return t - ((1.0f - m.value<CentringForce>(lift)) * dot(t, n)) * n;
  }
};

}  // namespace simplexseg
