// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "forces/line_search.h"

namespace simplexseg {

/// Pulls each vertex to the strongest edge along its normal n. Searches x + j s n, j = -m..m, for the largest response:
/// |grad I|, -dI/dn for a bright object or dI/dn for a dark one; d = j* s n with parabolic refinement. Ties go to the
/// smallest |j|. Samples outside the volume are ignored. The force is 0 unless the best response exceeds the threshold
/// (docs/mathematics.md, section 2.3).
struct GradientForce {
  static constexpr ForceId id = ForceId::Gradient;
  static constexpr ForceKind kind = ForceKind::Image;
  static constexpr const char *targets_name = "gradient targets", *search_name = "gradient search";
  static constexpr const char* name = "gradient";
  static constexpr const char* title = "Gradient";
  static constexpr const char* doc = "Pulls each vertex to the strongest image edge along its normal.";
  enum Parameter : int { weight, samples, spacing, object, threshold, pull, parameter_count };
  static constexpr ParameterInfo parameters[] = {
      {"weight", 0, 0, 10, "", "Strength of the force; 0 disables it."},
      {"samples", 6, 1, kMaxSearch, "", "Samples to each side of the vertex.", ParameterKind::Integer},
      {"spacing", 0.5f, 0.05f, 4, "voxel", "Distance between samples."},
      {"object", 0, 0, 2, "", "Edges that count: any, those of a bright object, or those of a dark object.",
       ParameterKind::Choice, "any|bright|dark"},
      {"threshold", 0.01f, 0, 1, "1/voxel", "Weakest edge that attracts, as a share of the volume's intensity range."},
      {"pull", 1, 0, 20, "voxel", "Largest displacement; 0: no limit."},
  };
  static constexpr float stability_bound(const ForceParameters&) { return 1.0f; }
  /// Number of scratch floats of a search: samples and responses, and a margin.
  static constexpr int scratch_floats(const ForceParameters& p) { return 4 * p.integer(id, samples) + 6; }
  /// Number of volume samples of a search, for the step plan.
  static constexpr int samples_of_search(const ForceParameters& p) { return 2 * p.integer(id, samples) + 1; }
  /// Runs the kernels that find the targets.
  template <class Voxels, int kWidth, class Searches>
  static void find_targets(Searches& searches);

  /// Confidence in the target of vertex i, 0 or 1.
  template <class I>
  SIMPLEXSEG_HD static Real<I> confidence(const StepView& v, I i) {
    return load_w(v.targets_of<GradientForce>(), i);
  }
  template <class I, class Neighbours, class R>
  SIMPLEXSEG_HD static Vec3Of<R> displacement(const StepView& v, const MeshConstants& m, I i, Neighbours, Vec3Of<R> p,
                                              Vec4Of<R> frame) {
    return pull_to_target(load(v.targets_of<GradientForce>(), i), p, xyz(frame),
                          m.value<GradientForce>(pull) * m.voxel_mm);
  }
};

/// Finds the targets of the gradient force. `Voxels`: sampler of the volume (forces/sampling.h).
template <class Voxels, int kWidth>
struct GradientSearch {
  static constexpr const char* name = GradientForce::search_name;
  static constexpr int kLanes = kWidth, kMaxSamples = 2 * kMaxSearch + 3;
  StepView v;
  int scratch;  ///< number of scratch floats: samples and responses of the longest search
  template <class I, class L>
  SIMPLEXSEG_HD void operator()(I i, L lanes) const {
    using R = Real<I>;
    const MeshConstants& m = v.meshes[v.neighbours[i].w];
    if (!(m.forces.weight(ForceId::Gradient) > 0.0f)) {
      if (lanes.lane == 0) store(v.targets_of<GradientForce>(), i, Vec4Of<R>{0, 0, 0, 0});
      return;
    }
    const Vec3Of<R> p = xyz(v.current[i]), n = xyz(v.frame[i]);
    const int reach = m.integer<GradientForce>(GradientForce::samples), count = 2 * reach + 3;
    const float step = m.value<GradientForce>(GradientForce::spacing) * m.voxel_mm;
    const int object = m.integer<GradientForce>(GradientForce::object);
    const IndexLineOf<R> line = index_line(v.volume, p, n);
    const Voxels voxels(v.volume);
    // Converts the threshold from shares of the intensity range per voxel to intensities per mm.
    const float threshold = m.value<GradientForce>(GradientForce::threshold) / (m.voxel_mm * v.volume.intensity_scale);
    const float start = -(reach + 1) * step, scale = (object == 1 ? -0.5f : 0.5f) / step;
    // The term 0 * here makes the response NaN at a NaN voxel.
    auto response = [scale](R before, R here, R after)
                        SIMPLEXSEG_INLINED { return scale * (after - before) + 0.0f * here; };
    auto responses = lanes.template scratch<kMaxSamples>(0);
    PeakOf<R> peak;
    if (object == 0) {
      peak = find_peak(lanes, responses, reach, [&](int k) SIMPLEXSEG_INLINED {
        return gradient_magnitude_at(voxels, v.volume, line.origin + ((k - reach) * step) * line.direction);
      });
    } else if constexpr (L::kStreams) {
      auto search = [&](auto samples) SIMPLEXSEG_INLINED {
        return find_peak(lanes, responses, reach, [&](int k) SIMPLEXSEG_INLINED { return samples.next(k, response); });
      };
#ifdef __CUDA_ARCH__
      if (contains(v.volume, line, start, start + (count - 1) * step))
        peak = search(SampleStream<Voxels, true>(voxels, v.volume, line, start, step));
      else
#endif
        peak = search(SampleStream<Voxels, false, R>(voxels, v.volume, line, start, step));
    } else {
      auto samples = lanes.template scratch<kMaxSamples>(count);
      sample_line(voxels, v.volume, lanes, line, start, step, count, samples);
      peak = find_peak(lanes, responses, reach,
                       [&](int k) { return response(samples[k], samples[k + 1], samples[k + 2]); });
    }
    const BooleanOf<R> found = (peak.best > threshold) & (peak.best > 0.0f);
    if (lanes.lane == 0)
      store(v.targets_of<GradientForce>(), i,
            with_w(p + choose(found, peak.offset() * step, R(0.0f)) * n, choose(found, R(1.0f), R(0.0f))));
  }
};

template <class Voxels, int kWidth, class Searches>
void GradientForce::find_targets(Searches& searches) {
  searches.search(GradientSearch<Voxels, kWidth>{searches.view(), kWidth > 1 ? searches.scratch_floats(id) : 0});
}

}  // namespace simplexseg
