// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "forces/line_search.h"

namespace simplexseg {

/// Pulls each vertex along its normal to the best match of its recorded reference profile. Profiles are compared by
/// normalised cross-correlation (accepted from a minimum; a profile of zero variance never matches) or by mean absolute
/// difference (accepted up to a maximum). The line is sampled once over the whole range, then compared with the
/// reference at each shift (docs/mathematics.md, section 2.4).
struct IntensityProfileForce {
  static constexpr ForceId id = ForceId::IntensityProfile;
  static constexpr ForceKind kind = ForceKind::Image;
  static constexpr const char *targets_name = "profile targets", *search_name = "profile search";
  static constexpr const char* name = "intensity_profile";
  static constexpr const char* title = "Intensity profile";
  static constexpr const char* doc =
      "Pulls each vertex to the position that matches its recorded reference profile best.";
  enum Parameter : int { weight, half_length, samples, spacing, measure, acceptance, pull, parameter_count };
  static constexpr ParameterInfo parameters[] = {
      {"weight", 0, 0, 10, "", "Strength of the force; 0 disables it."},
      {"half_length", 4, 1, kMaxProfile, "",
       "Samples of the reference profile to each side; record profiles again after a change, unless a model has them.",
       ParameterKind::Integer},
      {"samples", 6, 1, kMaxSearch, "", "Shifts tested to each side.", ParameterKind::Integer},
      {"spacing", 0.5f, 0.05f, 4, "voxel",
       "Distance between samples; record profiles again after a change, unless a model has them."},
      {"measure", 0, 0, 1, "", "Comparison of profiles: correlation, or mean absolute difference.",
       ParameterKind::Choice, "correlation|difference"},
      {"acceptance", 0.2f, -1, 1, "",
       "Acceptance threshold: minimum correlation (correlation), or maximum difference as a share of the intensity "
       "range (difference)."},
      {"pull", 1, 0, 20, "voxel", "Largest displacement; 0: no limit."},
  };
  static constexpr float stability_bound(const ForceParameters&) { return 1.0f; }
  /// True if reference profiles for the parameters `a` fit `b`, too.
  static constexpr bool same_samples(const ForceParameters& a, const ForceParameters& b) {
    constexpr int force = static_cast<int>(id);
    return a.integer(id, half_length) == b.integer(id, half_length) &&
           a.values[force][spacing] == b.values[force][spacing];
  }
  /// Number of values in the reference profile of a vertex.
  static constexpr int profile_length(const ForceParameters& p) { return 2 * p.integer(id, half_length) + 1; }
  /// True if the recorded profiles have the current length.
  static constexpr bool has_reference(const ForceParameters& p, const RecordedReferences& recorded) {
    return recorded.profile_values == static_cast<std::size_t>(recorded.vertex_count) * profile_length(p);
  }
  /// Number of scratch floats of a search: samples, reference and scores, and a margin.
  static constexpr int scratch_floats(const ForceParameters& p) {
    return 4 * p.integer(id, samples) + 1 + 2 * profile_length(p) + 8;
  }
  /// Number of volume samples of a search, for the step plan.
  static constexpr int samples_of_search(const ForceParameters& p) {
    return 2 * p.integer(id, samples) + profile_length(p);
  }
  /// Runs the kernels that find the targets.
  template <class Voxels, int kWidth, class Searches>
  static void find_targets(Searches& searches);

  /// Confidence in the target of vertex i, 0 or 1.
  template <class I>
  SIMPLEXSEG_HD static Real<I> confidence(const StepView& v, I i) {
    return load_w(v.targets_of<IntensityProfileForce>(), i);
  }
  template <class I, class Neighbours, class R>
  SIMPLEXSEG_HD static Vec3Of<R> displacement(const StepView& v, const MeshConstants& m, I i, Neighbours, Vec3Of<R> p,
                                              Vec4Of<R> frame) {
    return pull_to_target(load(v.targets_of<IntensityProfileForce>(), i), p, xyz(frame),
                          m.value<IntensityProfileForce>(pull) * m.voxel_mm);
  }
};

/// Finds the targets of the intensity profile force. `Voxels`: sampler of the volume (forces/sampling.h).
template <class Voxels, int kWidth>
struct ProfileSearch {
  static constexpr const char* name = IntensityProfileForce::search_name;
  /// Number of shifts compared together, so that each value of the reference is read once for all of them.
#ifdef __CUDA_ARCH__
  static constexpr int kTile = 4;
#else
  static constexpr int kTile = 8;
#endif
  static constexpr int kSamples = 2 * (kMaxSearch + kMaxProfile) + 1 + kTile;
  static constexpr int kLanes = kWidth, kLength = 2 * kMaxProfile + 1;
  StepView v;
  int scratch;  ///< number of scratch floats: samples, reference and scores of the longest search
  template <class L>
  SIMPLEXSEG_HD void operator()(int i, L lanes) const {
    using F = IntensityProfileForce;
    const MeshConstants& m = v.meshes[v.neighbours[i].w];
    const Vec3 p = xyz(v.current[i]), n = xyz(v.frame[i]);
    if (!(m.forces.weight(ForceId::IntensityProfile) > 0.0f)) {
      if (lanes.lane == 0) v.targets_of<IntensityProfileForce>()[i] = {0, 0, 0, 0};
      return;
    }
    const int half = m.integer<F>(F::half_length), reach = m.integer<F>(F::samples), length = 2 * half + 1;
    const int count = 2 * (reach + half) + 1;
    const float step = m.value<F>(F::spacing) * m.voxel_mm;
    const float* reference = v.profiles + static_cast<long>(i) * v.profile_stride;
    const IndexLine line = index_line(v.volume, p, n);
    const Voxels voxels(v.volume);
    auto values = lanes.template scratch<kSamples>(0);
    auto expected = lanes.template scratch<kLength>(count + kTile);
    auto scores = lanes.template scratch<2 * kMaxSearch + 1 + kTile>(count + kTile + length);
    const bool correlate = m.integer<F>(F::measure) == 0;
    // Correlation is invariant under a common offset. Subtracting the middle value of the reference avoids cancellation
    // in the sums of squares.
    const float base = correlate ? reference[half] : 0.0f, share = 1.0f / length;
    if constexpr (L::width == 1) {
      for (int k = 0; k < length; ++k) expected[k] = reference[k] - base;
      sample_line(voxels, v.volume, lanes, line, -(reach + half) * step, step, count, values, base);
    } else {
      // The loads of the reference overlap with the sampling of the volume.
      constexpr int kOwn = (kLength + L::width - 1) / L::width;
      float own[kOwn];
      for (int r = 0; r < kOwn; ++r)
        own[r] = lanes.lane + r * L::width < length ? reference[lanes.lane + r * L::width] : 0.0f;
      sample_line(voxels, v.volume, lanes, line, -(reach + half) * step, step, count, values, base);
      for (int r = 0; r < kOwn; ++r)
        if (lanes.lane + r * L::width < length) expected[lanes.lane + r * L::width] = own[r] - base;
    }
    for (int k = lanes.lane; k < kTile; k += L::width) values[count + k] = 0.0f;
    lanes.sync();
    float reference_mean = 0, reference_square = 0;
    for (int k = 0; k < length; ++k) reference_mean += expected[k], reference_square += expected[k] * expected[k];
    reference_mean *= share;
    reference_square -= length * reference_mean * reference_mean;
    // A sample outside the volume or at a NaN voxel makes the sums of all shifts that contain it NaN, which excludes
    // these shifts.
    for (int start = lanes.lane * kTile; start <= 2 * reach; start += L::width * kTile) {
      float score[kTile];
      if (correlate) {
        float sum[kTile] = {}, squares[kTile] = {}, product[kTile] = {};
        for (int k = 0; k < length; ++k) {
          const float y = expected[k];
          for (int t = 0; t < kTile; ++t) {
            const float x = values[start + k + t];
            sum[t] += x, squares[t] += x * x, product[t] += x * y;
          }
        }
        for (int t = 0; t < kTile; ++t) {
          const float square = squares[t] - share * sum[t] * sum[t];
          // In a window without contrast the sums contain only rounding errors.
          const bool contrast = square > 1e-6f * squares[t] && reference_square > 0.0f;
          const float s = (product[t] - reference_mean * sum[t]) * inverse_sqrt(square * reference_square);
          score[t] = contrast && is_valid(s) ? s : NAN;
        }
      } else {
        float sum[kTile] = {};
        for (int k = 0; k < length; ++k) {
          const float y = expected[k];
          for (int t = 0; t < kTile; ++t) sum[t] -= fabsf(values[start + k + t] - y);
        }
        for (int t = 0; t < kTile; ++t) score[t] = is_valid(sum[t]) ? sum[t] * v.volume.intensity_scale * share : NAN;
      }
      for (int t = 0; t < kTile; ++t) scores[start + t] = score[t];
    }
    lanes.sync();
    const PeakOf<float> peak = find_peak(lanes, scores, reach, [&](int k) { return scores[k]; });
    if (lanes.lane != 0) return;
    const float acceptance = m.value<F>(F::acceptance);
    const bool found = peak.best > -1e29f && (correlate ? peak.best >= acceptance : -peak.best <= acceptance);
    v.targets_of<IntensityProfileForce>()[i] =
        with_w(p + (found ? peak.offset() * step : 0.0f) * n, found ? 1.0f : 0.0f);
  }
};

template <class Voxels, int kWidth, class Searches>
void IntensityProfileForce::find_targets(Searches& searches) {
  searches.search(ProfileSearch<Voxels, kWidth>{searches.view(), searches.scratch_floats(id)});
}

}  // namespace simplexseg
