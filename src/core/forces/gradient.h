// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "core/forces/line_search.h"

namespace simplexseg {

/// Pulls each vertex to the strongest edge along its normal: search x + j s n, j = -m..m, for the largest |grad I|, or the
/// largest -+dI/dn for a bright or a dark object; d = j* s n with parabolic refinement. Ties and flat profiles give j* = 0;
/// no sample outside the volume counts; no force where the best response is below the threshold
/// (docs/mathematics.md, section 2.3).
struct GradientForce {
  static constexpr ForceId id = ForceId::Gradient;
  static constexpr const char* name = "gradient";
  static constexpr const char* title = "Gradient";
  static constexpr const char* doc = "Pulls each vertex to the strongest image edge along its normal.";
  enum Parameter : int { weight, samples, spacing, object, threshold, pull, parameter_count };
  static constexpr ParameterInfo parameters[] = {
      {"weight", 0, 0, 10, "", "Strength of the force; 0 leaves it out."},
      {"samples", 6, 1, kMaxSearch, "", "Samples to each side of the vertex.", ParameterKind::Integer},
      {"spacing", 0.5f, 0.05f, 4, "voxel", "Distance of the samples."},
      {"object", 0, 0, 2, "", "Which edges count: any, the rim of a bright object, or the rim of a dark one.", ParameterKind::Choice, "any|bright|dark"},
      {"threshold", 0.01f, 0, 1, "1/voxel", "Weakest edge that pulls, as a share of the volume's intensity range."},
      {"pull", 1, 0, 20, "voxel", "Bound of the displacement; 0: none."},
  };
  static constexpr float stability_bound(const ForceParameters&) { return 1.0f; }

  SIMPLEXSEG_HD static Vec3 displacement(const StepView& v, const MeshConstants& m, int i, Int4, Vec3 p, Vec4 frame) {
    return pull_to_target(v.gradient_target[i], p, xyz(frame), m.value<GradientForce>(pull) * m.voxel_mm);
  }
};

/// Finds the targets of the gradient force, T = voxel type.
template <class T>
struct GradientSearch {
  static constexpr const char* name = "gradient search";
  StepView v;
  SIMPLEXSEG_HD void operator()(int i) const {
    const MeshConstants& m = v.meshes[v.neighbours[i].w];
    const Vec3 p = xyz(v.current[i]), n = xyz(v.frame[i]);
    const int reach = m.integer<GradientForce>(GradientForce::samples);
    const float step = m.value<GradientForce>(GradientForce::spacing) * m.voxel_mm;
    const int object = m.integer<GradientForce>(GradientForce::object);
    const IndexLine line = index_line(v.volume, p, n);
    // Per mm, in shares of the intensity range.
    const float threshold = m.value<GradientForce>(GradientForce::threshold) / (m.voxel_mm * v.volume.intensity_scale);
    float best = -1e30f, before_best = 0, after_best = 0, last = 0;
    int best_j = 0;
    bool want_after = false, last_valid = false, before_valid = false, after_valid = false;
    auto consider = [&](int j, float response, bool valid) {
      if (want_after) after_best = response, after_valid = valid, want_after = false;
      const bool nearer = (j < 0 ? -j : j) < (best_j < 0 ? -best_j : best_j);
      if (valid && (response > best || (response == best && nearer))) {
        best = response, best_j = j;
        before_best = last, before_valid = last_valid, want_after = true, after_valid = false;
      }
      last = response, last_valid = valid;
    };
    if (object == 0) {
      for (int j = -reach; j <= reach; ++j) {
        const Sample s = squared_gradient_at<T>(v.volume, line.origin + (j * step) * line.direction);
        consider(j, sqrtf(s.value), s.inside);
      }
    } else {
      const float sign = (object == 1 ? -0.5f : 0.5f) / step;
      Sample a = sample_at<T>(v.volume, line.origin + ((-reach - 1) * step) * line.direction);
      Sample b = sample_at<T>(v.volume, line.origin + (-reach * step) * line.direction);
      for (int j = -reach; j <= reach; ++j) {
        const Sample c = sample_at<T>(v.volume, line.origin + ((j + 1) * step) * line.direction);
        consider(j, sign * (c.value - a.value), a.inside && b.inside && c.inside);
        a = b, b = c;
      }
    }
    const bool found = best > threshold && best > 0.0f;
    float offset = 0;
    if (found) {
      offset = static_cast<float>(best_j);
      if (before_valid && after_valid) offset += parabolic_peak(before_best, best, after_best);
    }
    v.gradient_target[i] = with_w(p + (offset * step) * n, found ? 1.0f : 0.0f);
  }
};

}  // namespace simplexseg
