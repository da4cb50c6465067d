// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "core/forces/line_search.h"

namespace simplexseg {

/// Pulls each vertex to where the intensities along its normal look most like its recorded reference profile: normalised
/// cross-correlation (accepted above a threshold; zero variance matches nothing) or mean absolute difference. The line is
/// sampled once over the whole range, then compared at each shift (docs/mathematics.md, section 2.4).
struct IntensityProfileForce {
  static constexpr ForceId id = ForceId::IntensityProfile;
  static constexpr const char* name = "intensity_profile";
  static constexpr const char* title = "Intensity profile";
  static constexpr const char* doc = "Pulls each vertex to where the image looks like its recorded reference profile.";
  enum Parameter : int { weight, half_length, samples, spacing, measure, acceptance, pull, parameter_count };
  static constexpr ParameterInfo parameters[] = {
      {"weight", 0, 0, 10, "", "Strength of the force; 0 leaves it out."},
      {"half_length", 4, 1, kMaxProfile, "", "Samples of the reference profile to each side; record the profiles again after changing it.", ParameterKind::Integer},
      {"samples", 6, 1, kMaxSearch, "", "Shifts that are tried to each side.", ParameterKind::Integer},
      {"spacing", 0.5f, 0.05f, 4, "voxel", "Distance of the samples."},
      {"measure", 0, 0, 1, "", "How profiles are compared: correlation, or mean absolute difference.", ParameterKind::Choice, "correlation|difference"},
      {"acceptance", 0.2f, -1, 1, "", "Least correlation that pulls (correlation), or largest difference as a share of the intensity range (difference)."},
      {"pull", 1, 0, 20, "voxel", "Bound of the displacement; 0: none."},
  };
  static constexpr float stability_bound(const ForceParameters&) { return 1.0f; }

  SIMPLEXSEG_HD static Vec3 displacement(const StepView& v, const MeshConstants& m, int i, Int4, Vec3 p, Vec4 frame) {
    return pull_to_target(v.profile_target[i], p, xyz(frame), m.value<IntensityProfileForce>(pull) * m.voxel_mm);
  }
};

template <class T>
struct ProfileSearch {
  static constexpr const char* name = "profile search";
  StepView v;
  SIMPLEXSEG_HD void operator()(int i) const {
    using F = IntensityProfileForce;
    const MeshConstants& m = v.meshes[v.neighbours[i].w];
    const Vec3 p = xyz(v.current[i]), n = xyz(v.frame[i]);
    v.profile_target[i] = with_w(p, 0.0f);
    if (!(m.forces.weight(ForceId::IntensityProfile) > 0.0f)) return;
    const int half = m.integer<F>(F::half_length), reach = m.integer<F>(F::samples), length = 2 * half + 1;
    const float step = m.value<F>(F::spacing) * m.voxel_mm;
    const float* reference = v.profiles + static_cast<long>(i) * v.profile_stride;
    const IndexLine line = index_line(v.volume, p, n);
    float values[2 * (kMaxSearch + kMaxProfile) + 1];
    sample_line<T>(v.volume, line, -(reach + half) * step, step, 2 * (reach + half) + 1, values);
    int first = 2 * (reach + half) + 1, last = -1;        // the run of samples inside the volume (a line cuts a box once)
    for (int k = 0; k <= 2 * (reach + half); ++k)
      if (is_valid(values[k])) first = k < first ? k : first, last = k;
    const bool correlate = m.integer<F>(F::measure) == 0;
    float reference_mean = 0;
    for (int k = 0; k < length; ++k) reference_mean += reference[k];
    reference_mean /= length;
    float reference_square = 0;
    for (int k = 0; k < length; ++k) reference_square += (reference[k] - reference_mean) * (reference[k] - reference_mean);
    float score[2 * kMaxSearch + 1];
    int best_j = 0;
    float best = -1e30f;
    for (int j = -reach; j <= reach; ++j) {
      const int start = j + reach;
      float s = -1e30f;
      if (start >= first && start + length - 1 <= last) {
        if (correlate) {
          float mean = 0;
          for (int k = 0; k < length; ++k) mean += values[start + k];
          mean /= length;
          float square = 0, product = 0;
          for (int k = 0; k < length; ++k) {
            square += (values[start + k] - mean) * (values[start + k] - mean);
            product += (values[start + k] - mean) * (reference[k] - reference_mean);
          }
          const float both = square * reference_square;
          if (both > 0.0f) s = product / sqrtf(both);
        } else {
          s = 0;
          for (int k = 0; k < length; ++k) s -= fabsf(values[start + k] - reference[k]);
          s *= v.volume.intensity_scale / length;
        }
      }
      if (!is_valid(s)) s = -1e30f;        // a voxel that is not a number lies between valid ones
      score[start] = s;
      const bool nearer = (j < 0 ? -j : j) < (best_j < 0 ? -best_j : best_j);
      if (s > best || (s == best && nearer)) best = s, best_j = j;
    }
    const float acceptance = m.value<F>(F::acceptance);
    if (best <= -1e29f || (correlate ? best < acceptance : -best > acceptance)) return;
    float offset = static_cast<float>(best_j);
    if (best_j > -reach && best_j < reach && score[best_j + reach - 1] > -1e29f && score[best_j + reach + 1] > -1e29f)
      offset += parabolic_peak(score[best_j + reach - 1], best, score[best_j + reach + 1]);
    v.profile_target[i] = with_w(p + (offset * step) * n, 1.0f);
  }
};

}  // namespace simplexseg
