// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "forces/step_view.h"

namespace simplexseg {

/// Evens out edge lengths in the tangential direction and averages curvature in the normal direction:
///   d = sum_k w_k P_k + c h~ n - P,   w_k = |P_k - P|^a / sum_l |P_l - P|^a,   h~ = S mean(h_j / S_j)
/// where the mean is over rings 1 and 2 and S = |N| (docs/mathematics.md, section 2.1). c = 1 preserves the volume,
/// c = 0 is the plain Laplacian. The length weights perform a descent of the convex energy
/// sum |e|^(a+2). The averaged quantity is elevation over area, a curvature: with elevations themselves, large cells
/// would lift small ones, and elongated shapes would diverge (docs/adr/0003-smoothing.md).
struct SmoothingForce {
  static constexpr ForceId id = ForceId::Smoothing;
  static constexpr ForceKind kind = ForceKind::Internal;
  static constexpr const char* name = "smoothing";
  static constexpr const char* title = "Smoothing";
  static constexpr const char* doc = "Evens out the spacing of the vertices and averages their curvature.";
  enum Parameter : int { weight, evenness, curvature, elevation_limit, parameter_count };
  static constexpr ParameterInfo parameters[] = {
      {"weight", 2, 0, 10, "", "Strength of the force; 0 disables it."},
      {"evenness", 2, 0, 6, "",
       "Exponent of the edge length in the weight of a neighbour; 0: equal weights, large: long edges pull harder."},
      {"curvature", 0.3f, 0, 1, "",
       "Share of the mean curvature that is preserved; 1 preserves the volume, 0 is a plain Laplacian."},
      {"elevation_limit", 0.4f, 0, 2, "edges", "Largest preserved elevation, in mean edge lengths of the vertex."},
  };
  /// Upper bound of the largest eigenvalue of -d(displacement)/dx: 2 for a Laplacian with weights >= 0 that sum to 1,
  /// times (1 + a), the relative growth of |e|^a e along a dominant edge e.
  static constexpr float stability_bound(const ForceParameters& p) {
    return 2.0f * (1.0f + p.values[static_cast<int>(id)][evenness]);
  }

  template <class I, class Neighbours, class R>
  SIMPLEXSEG_HD static Vec3Of<R> displacement(const StepView& v, const MeshConstants& m, I, Neighbours nb, Vec3Of<R> p,
                                              Vec4Of<R> frame) {
    const Vec3Of<R> p1 = xyz(v.current[nb.x]), p2 = xyz(v.current[nb.y]), p3 = xyz(v.current[nb.z]);
    const Vec3Of<R> e1 = p1 - p, e2 = p2 - p, e3 = p3 - p;
    const R l1 = dot(e1, e1), l2 = dot(e2, e2), l3 = dot(e3, e3);
    const float a = 0.5f * m.value<SmoothingForce>(evenness);
    R w1 = 1, w2 = 1, w3 = 1;
    if (a == 1.0f) {
      w1 = l1, w2 = l2, w3 = l3;
    } else if (a != 0.0f) {
      const R largest = larger(l1, larger(l2, l3));
      const R s = R(1.0f) / largest;  // computes ratios first, to avoid overflow for any unit
      const auto nonzero = largest > 0.0f;
      w1 = choose(nonzero, powf(l1 * s, a), w1), w2 = choose(nonzero, powf(l2 * s, a), w2),
      w3 = choose(nonzero, powf(l3 * s, a), w3);
    }
    const R sum = w1 + w2 + w3;
    const auto degenerate = !(sum > 1e-30f);
    const R inverse = choose(degenerate, R(1.0f / 3.0f), R(1.0f) / sum);
    w1 = choose(degenerate, R(1.0f), w1), w2 = choose(degenerate, R(1.0f), w2), w3 = choose(degenerate, R(1.0f), w3);
    const Vec3Of<R> laplacian = inverse * (w1 * e1 + (w2 * e2 + w3 * e3));
    const float keep = m.value<SmoothingForce>(curvature);
    R mean = 0;
    if (keep > 0.0f) {
      // Rings 1 and 2: the three neighbours, and the two other neighbours of each. Subtracts the vertex itself, which
      // is a neighbour of all three.
      const Vec4Of<R> f1 = v.frame[nb.x], f2 = v.frame[nb.y], f3 = v.frame[nb.z];
#ifdef __CUDA_ARCH__
      const auto n1 = v.neighbours[nb.x], n2 = v.neighbours[nb.y], n3 = v.neighbours[nb.z];
      mean = f1.w + f2.w + f3.w + v.frame.w(n1.x) + v.frame.w(n1.y) + v.frame.w(n1.z) + v.frame.w(n2.x) +
             v.frame.w(n2.y) + v.frame.w(n2.z) + v.frame.w(n3.x) + v.frame.w(n3.y) + v.frame.w(n3.z) - 3.0f * frame.w;
#else
      mean = f1.w + f2.w + f3.w + load(v.ring_sums, nb.x) + load(v.ring_sums, nb.y) + load(v.ring_sums, nb.z) -
             3.0f * frame.w;
#endif
      mean *= 1.0f / 9.0f;
      const Vec3Of<R> n = xyz(frame);
      // At a fold, where normals flip, averaging the curvature would preserve the fold. A plain Laplacian step removes
      // it.
      const auto folded = (dot(n, xyz(f1)) < 0.0f) | (dot(n, xyz(f2)) < 0.0f) | (dot(n, xyz(f3)) < 0.0f);
      const R bound = m.value<SmoothingForce>(elevation_limit) * (1.0f / 3.0f) * (sqrtf(l1) + sqrtf(l2) + sqrtf(l3));
      mean *= norm(cross(p2 - p1, p3 - p1));
      mean = choose(folded, R(0.0f), keep * smaller(larger(mean, -bound), bound));
    }
    return laplacian + mean * xyz(frame);
  }
};

}  // namespace simplexseg
