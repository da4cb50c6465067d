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
    float samples[2 * kMaxSearch + 3], response[2 * kMaxSearch + 1];
    if (object == 0) {
      for (int k = 0; k <= 2 * reach; ++k) response[k] = gradient_magnitude_at<T>(v.volume, line.origin + ((k - reach) * step) * line.direction);
    } else {
      sample_line<T>(v.volume, line, -(reach + 1) * step, step, 2 * reach + 3, samples);
      const float scale = (object == 1 ? -0.5f : 0.5f) / step;
      for (int k = 0; k <= 2 * reach; ++k) response[k] = scale * (samples[k + 2] - samples[k]) + 0.0f * samples[k + 1];
    }
    float best = -1e30f;
    for (int k = 0; k <= 2 * reach; ++k) best = larger(response[k], best);
    // Of equal responses the nearest one; of two as near, the inner one.
    int best_k = reach;
    for (int j = 0; j <= reach; ++j) {
      if (response[reach - j] == best || response[reach + j] == best) {
        best_k = response[reach - j] == best ? reach - j : reach + j;
        break;
      }
    }
    const bool found = best > threshold && best > 0.0f;
    float offset = 0;
    if (found) {
      offset = static_cast<float>(best_k - reach);
      if (best_k > 0 && best_k < 2 * reach && is_valid(response[best_k - 1]) && is_valid(response[best_k + 1]))
        offset += parabolic_peak(response[best_k - 1], best, response[best_k + 1]);
    }
    v.gradient_target[i] = with_w(p + (offset * step) * n, found ? 1.0f : 0.0f);
  }
};

}  // namespace simplexseg
