// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <span>

#include "forces/step_view.h"

namespace simplexseg {

/// Pulls every vertex to its position relative to its neighbours in the reference pose:
///   d = sum_k e_k^ref P_k + h~ n - P,   h~ = h^ref (S / S^ref)^b   (Delingette 1999; docs/mathematics.md,
///   section 2.2).
/// The force is invariant under similarities for b = 1/2, but only under rigid motions for b = 0. Its stability bound
/// relies on bounded metric parameters of the reference (src/mesh/shape_reference.h).
struct ShapeMemoryForce {
  static constexpr ForceId id = ForceId::ShapeMemory;
  static constexpr ForceKind kind = ForceKind::Internal;
  static constexpr const char* name = "shape_memory";
  static constexpr const char* title = "Shape memory";
  static constexpr const char* doc = "Pulls the mesh back to the local shape of its reference pose.";
  enum Parameter : int { weight, scaling, parameter_count };
  static constexpr ParameterInfo parameters[] = {
      {"weight", 0, 0, 10, "", "Strength of the force; 0 disables it."},
      {"scaling", 0.5f, 0, 1, "",
       "Exponent of the area ratio that scales the elevation; 0.5: invariant under similarities, 0: under rigid "
       "motions only."},
  };
  static constexpr bool has_reference(const ForceParameters&, const RecordedReferences& recorded) {
    return recorded.shape;
  }
  /// Bound 1 + the largest sum |e_k| over the vertices of the reference (2 if all e_k >= 0); 0 without a reference.
  static float stability_bound(const ForceParameters&, std::span<const Vec4> shape) {
    float largest = 1.0f;
    for (const Vec4& s : shape) {
      const float sum = fabsf(s.x) + fabsf(s.y) + fabsf(1.0f - s.x - s.y);
      largest = sum > largest ? sum : largest;
    }
    return shape.empty() ? 0.0f : 1.0f + largest;
  }

  template <class I, class Neighbours, class R>
  SIMPLEXSEG_HD static Vec3Of<R> displacement(const StepView& v, const MeshConstants& m, I i, Neighbours nb,
                                              Vec3Of<R> p, Vec4Of<R> frame) {
    const Vec3Of<R> p1 = xyz(v.current[nb.x]), p2 = xyz(v.current[nb.y]), p3 = xyz(v.current[nb.z]);
    const Vec4Of<R> ref = v.shape[i];
    const float b = m.value<ShapeMemoryForce>(scaling);
    R h = ref.z;
    if (b > 0.0f) {
      const R ratio = norm(cross(p2 - p1, p3 - p1)) / ref.w;
      h = choose(ref.w > 0.0f, h * (b == 0.5f ? sqrtf(ratio) : powf(ratio, b)), h);
    }
    // Subtracts P1 first, which avoids cancellation for positions far from the origin.
    const Vec3Of<R> foot = ref.y * (p2 - p1) + (1.0f - ref.x - ref.y) * (p3 - p1);
    return (foot + h * xyz(frame)) - (p - p1);
  }
};

}  // namespace simplexseg
