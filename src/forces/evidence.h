// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "forces/field_surface.h"
#include "forces/line_search.h"
#include "forces/region_model.h"

namespace simplexseg {

/// Pulls a mesh to the surface of its object. The target of a vertex is the position along its normal with the most
/// evidence for the object inside and for the background outside. With the evidence l in [-1, 1] of each sample,
///   score(j) = sum_{i<j} l_i s + g |dI/dn| - c |j| s,   d = s argmax score
/// (docs/mathematics.md, section 2.5). The evidence is the mesh's foreground probability field, computed from the
/// user's marks (src/field/), or the log-likelihood ratio of intensities in the mesh's region model
/// (src/forces/region_model.h), on the finest level also the log-likelihood ratio in local statistics of both sides.
/// Targets away from the surface of a field are averaged over neighbours, which keeps the mesh smooth.
struct EvidenceForce {
  static constexpr ForceId id = ForceId::Evidence;
  static constexpr ForceKind kind = ForceKind::Image;
  static constexpr const char *targets_name = "evidence targets", *search_name = "evidence search";
  static constexpr const char* name = "evidence";
  static constexpr const char* title = "Evidence";
  static constexpr float kMaxEdgesPerSearch = 0.5f;
  static constexpr const char* doc = "Pulls the mesh to the surface of its object, which is computed from the marks.";
  enum Parameter : int {
    weight,
    reach,
    samples,
    edge,
    nearness,
    local,
    averaging,
    pull,
    balloon,
    source,
    hold,
    parameter_count
  };
  static constexpr ParameterInfo parameters[] = {
      {"weight", 0.5f, 0, 10, "", "Strength of the force; 0 disables it."},
      {"reach", 2.0f, 0.5f, 10, "edges",
       "Search distance to each side, in mean edge lengths (of the vertex with the source 'field', else of the mesh "
       "when created or refined); at least 2.5 voxels."},
      {"samples", 8, 2, kMaxSearch, "", "Samples to each side of the vertex.", ParameterKind::Integer},
      {"edge", 2.0f, 0, 10, "", "Weight of the image gradient relative to the evidence."},
      {"nearness", 0.2f, 0, 2, "", "Preference for near boundaries over far ones; only for the source 'intensities'."},
      {"local", 0.3f, 0, 1, "",
       "Share of the evidence from nearby intensities, on the finest level; only for the source 'intensities'."},
      {"averaging", 2, 0, 8, "", "Passes of averaging the targets over neighbours.", ParameterKind::Integer},
      {"pull", 2, 0, 20, "voxel", "Largest displacement; 0: no limit."},
      {"balloon", 0, -1, 1, "",
       "Added to the evidence of every sample: positive values grow the mesh, negative values shrink it."},
      {"source", 0, 0, 1, "",
       "Source of the evidence: the field computed from the marks, or the intensities inside and around the seed.",
       ParameterKind::Choice, "field|intensities"},
      {"hold", 8, 1, 20, "",
       "Factor on the force where the mesh lies close to the surface of the field and faces in the same direction."},
  };
  static constexpr bool from_field(const ForceParameters& p) { return p.integer(id, source) == 0; }
  /// True if local intensities on both sides of the surface are used once the mesh is on its finest level.
  static constexpr bool has_local_evidence(const ForceParameters& p) {
    return !from_field(p) && p.values[static_cast<int>(id)][local] > 0;
  }
  /// True if local intensities are used for a mesh in this step.
  SIMPLEXSEG_HD static bool uses_local_statistics(const MeshConstants& m) {
    return m.finest != 0 && m.forces.weight(id) > 0.0f && m.integer<EvidenceForce>(source) != 0 &&
           m.value<EvidenceForce>(local) > 0.0f;
  }
  /// True if the mesh has the field that the source 'field' requires; always true for the source 'intensities'.
  static constexpr bool has_reference(const ForceParameters& p, const RecordedReferences& recorded) {
    return !from_field(p) || recorded.field;
  }
  static constexpr float stability_bound(const ForceParameters& p) {
    return from_field(p) ? p.values[static_cast<int>(id)][hold] : 1.0f;
  }
  /// Number of scratch floats of a search: intensities and evidence of the samples.
  static constexpr int scratch_floats(const ForceParameters& p) { return 2 * (2 * p.integer(id, samples) + 1); }
  /// Number of volume samples of a search, for the step plan.
  static constexpr int samples_of_search(const ForceParameters& p) { return 2 * p.integer(id, samples) + 1; }
  /// Runs the kernels that find the targets.
  template <class Voxels, int kWidth, class Searches>
  static void find_targets(Searches& searches);

  /// Factor on the weight of the force at vertex i, in [0, hold].
  template <class I>
  SIMPLEXSEG_HD static Real<I> confidence(const StepView& v, I i) {
    return load_w(v.targets_of<EvidenceForce>(), i);
  }
  template <class I, class Neighbours, class R>
  SIMPLEXSEG_HD static Vec3Of<R> displacement(const StepView& v, const MeshConstants& m, I i, Neighbours, Vec3Of<R> p,
                                              Vec4Of<R> frame) {
    return pull_to_target(load(v.targets_of<EvidenceForce>(), i), p, xyz(frame),
                          m.value<EvidenceForce>(pull) * m.voxel_mm);
  }
  template <class R>
  SIMPLEXSEG_HD static R search_step_mm(const MeshConstants& m, R edge_mm) {
    return larger(m.value<EvidenceForce>(reach) * edge_mm, R(2.5f * m.voxel_mm)) /
           static_cast<float>(m.integer<EvidenceForce>(samples));
  }
};

/// Mean length of the three edges of a vertex, mm.
template <class I>
SIMPLEXSEG_HD Real<I> mean_edge_at(const StepView& v, I i) {
  const auto nb = v.neighbours[i];
  const Vec3Of<Real<I>> p = xyz(v.current[i]);
  return (norm(xyz(v.current[nb.x]) - p) + norm(xyz(v.current[nb.y]) - p) + norm(xyz(v.current[nb.z]) - p)) / 3.0f;
}

/// Sign change of the evidence along a search line, relative to the middle of the line.
template <class R>
struct Crossing {
  R shift;                   ///< signed distance from the middle, samples
  BooleanOf<R> found;        ///< false: no sign change within reach
  BooleanOf<R> from_inside;  ///< true: the middle lies in the object, the search goes outwards; false: inwards
};
template <class R, class Ratios>
SIMPLEXSEG_HD Crossing<R> crossing_of(Ratios& ratio, int reach) {
  const R middle = ratio[reach];
  const BooleanOf<R> inside = middle > 0.0f, outside = !inside;
  const BooleanOf<R> none = R(0.0f) > R(0.0f);
  Crossing<R> crossing{choose(inside, R(static_cast<float>(reach)), R(static_cast<float>(-reach))), none, inside};
  // Records the first crossing between samples k and k + 1: out of the object or, from outside, into the object.
  auto record = [&](int k, BooleanOf<R> here) SIMPLEXSEG_INLINED {
    const R before = ratio[k], after = ratio[k + 1];
    const R between = static_cast<float>(k) + before / (before - after) - static_cast<float>(reach);
    const BooleanOf<R> open = !crossing.found, first = here & open;
    crossing.shift = choose(first, between, crossing.shift);
    crossing.found = crossing.found | first;
  };
  for (int k = reach; k < 2 * reach && !all(crossing.found | outside); ++k) {
    const R after = ratio[k + 1];
    const BooleanOf<R> leaves = !(after > 0.0f);
    record(k, inside & leaves);
  }
  for (int k = reach - 1; k >= 0 && !all(crossing.found | inside); --k) {
    const R before = ratio[k];
    record(k, outside & (before > 0.0f));
  }
  return crossing;
}

/// Shift of a crossing (samples), moved towards image edges within one voxel where the field is uncertain.
template <class R, class Ratios, class Values>
SIMPLEXSEG_HD R shift_towards_edges(const Crossing<R>& crossing, Ratios& ratio, Values& value, int reach, R step_voxels,
                                    float edge) {
  if (!any(crossing.found)) return crossing.shift;
  R sum = crossing.shift, weights = 1;
  for (int k = 1; k < 2 * reach; ++k) {
    const float shift = static_cast<float>(k - reach);
    const R distance = fabsf(shift - crossing.shift) * step_voxels;
    const R weight =
        choose(distance < 1.0f, edge * (1.0f - ratio[k] * ratio[k]) * fabsf(value[k + 1] - value[k - 1]), R(0.0f));
    sum += weight * shift, weights += weight;
  }
  return choose(crossing.found, sum / weights, crossing.shift);
}

/// Number of passes that average local statistics over neighbours.
inline constexpr int kStatisticsPasses = 4;

/// Local intensities as shares of the region model's range: mean inside (x) and outside (y), pooled variance (z).
template <class Voxels, int kWidth>
struct EvidenceStatistics {
  static constexpr const char* name = "evidence statistics";
  static constexpr int kSamples = 4;  ///< samples to each side, one voxel apart, from one voxel off the surface
  static constexpr int kLanes = kWidth, kCount = 2 * kSamples + 1;
  StepView v;
  int scratch;  ///< number of scratch floats: kCount
  template <class I, class L>
  SIMPLEXSEG_HD void operator()(I i, L lanes) const {
    using R = Real<I>;
    const MeshConstants& m = v.meshes[v.neighbours[i].w];
    if (!EvidenceForce::uses_local_statistics(m)) return;
    const IndexLineOf<R> line = index_line(v.volume, xyz(v.current[i]), xyz(v.frame[i]));
    R mean[2], variance = 0, count = 0;
    auto values = lanes.template scratch<kCount>(0);
    sample_line(Voxels(v.volume), v.volume, lanes, line, -kSamples * m.voxel_mm, m.voxel_mm, kCount, values);
    if (lanes.lane != 0) return;
    for (int side = 0; side < 2; ++side) {
      R sum = 0, square = 0, n = 0;
      for (int j = 1; j <= kSamples; ++j) {
        const R value = (values[side == 0 ? kSamples - j : kSamples + j] - m.intensity_low) * m.intensity_scale;
        const BooleanOf<R> valid = is_valid(value);
        sum = choose(valid, sum + value, sum), square = choose(valid, square + value * value, square);
        n = choose(valid, n + 1.0f, n);
      }
      mean[side] = choose(n > 0.0f, sum / n, R(0.0f));
      variance = variance + choose(n > 0.0f, square - n * mean[side] * mean[side], R(0.0f));
      count = count + n;
    }
    store(v.local_statistics, i,
          Vec4Of<R>{mean[0], mean[1], choose(count > 0.0f, larger(variance, R(0.0f)) / count, R(0.0f)), 0.0f});
  }
};

template <class Voxels, int kWidth>
struct EvidenceSearch {
  static constexpr const char* name = EvidenceForce::search_name;
  static constexpr int kSamples = 2 * kMaxSearch + 1;
  static constexpr int kLanes = kWidth;
  StepView v;
  int scratch;  ///< number of scratch floats: intensities and evidence of the longest search
  template <class I, class L>
  SIMPLEXSEG_HD void operator()(I i, L lanes) const {
    using F = EvidenceForce;
    using R = Real<I>;
    const MeshConstants& m = v.meshes[v.neighbours[i].w];
    if (!(m.forces.weight(ForceId::Evidence) > 0.0f)) {
      if (lanes.lane == 0) store(v.targets_of<EvidenceForce>(), i, Vec4Of<R>{0, 0, 0, 0});
      return;
    }
    const bool from_field = F::from_field(m.forces);
    const int reach = m.integer<F>(F::samples);
    const R step = F::search_step_mm(m, from_field ? mean_edge_at(v, i) : R(m.edge_mm)),
            step_voxels = step / m.voxel_mm;
    const Vec3Of<R> n = xyz(v.frame[i]);
    IndexLineOf<R> line = index_line(v.volume, xyz(v.current[i]), n);
    SearchLine<R> search{n, 0};
    if (from_field) {
      search = field_search_line(v, m, line.origin, search.direction);
      line.direction = rotate_to_index(v.volume, search.direction);
    }
    const float* table = m.region_table >= 0 ? v.region_tables + m.region_table : nullptr;
    const float balloon = m.value<F>(F::balloon);
    float local = 0;
    R middle = 0, slope = 0;
    if (v.local_statistics && m.finest && !from_field) {
      local = m.value<F>(F::local);
      const Vec4Of<R> s = load(v.local_statistics, i);
      const R contrast = s.x - s.y;
      middle = 0.5f * (s.x + s.y);
      // Log-likelihood ratio of two Gaussians of equal variance. The added variance suppresses flat neighbourhoods.
      slope = contrast / (s.z + 0.25f * contrast * contrast + 1e-4f);
    }
    auto share = [&](R intensity) SIMPLEXSEG_INLINED {
      return smaller(larger((intensity - m.intensity_low) * m.intensity_scale, R(0.0f)), R(1.0f));
    };
    auto evidence_of = [&](R intensity) SIMPLEXSEG_INLINED {
      const R x = share(intensity);
      R l = 0;
      if (table) l = gather(table, to_integer(x * (kRegionBins - 1) + 0.5f));
      if (local > 0.0f) l = (1.0f - local) * l + local * smaller(larger((x - middle) * slope, R(-1.0f)), R(1.0f));
      return smaller(larger(l + balloon, R(-1.0f)), R(1.0f));
    };
    auto evidence_of_field = [&](R texel) SIMPLEXSEG_INLINED {
      const R p = texel * (1.0f / kFieldScale);
      return smaller(larger(kFieldGain * (2.0f * p - 1.0f) + balloon, R(-1.0f)), R(1.0f));
    };
    const int count = 2 * reach + 1;
    auto value = lanes.template scratch<kSamples>(0);
    auto ratio = lanes.template scratch<kSamples>(count);
    const R start = -static_cast<float>(reach) * step;
    sample_line(Voxels(v.volume), v.volume, lanes, line, start, step, count, value);
    if (from_field) {
      const VolumeView field = field_view(v, m);
      const IndexLineOf<R> in_box{m.field.index(line.origin), m.field.difference(line.direction)};
      sample_line(LinearVoxels<std::uint16_t>(field), field, lanes, in_box, start, step, count, ratio);
    }
    const CoveredBox covered(v, m);
    for (int k = lanes.lane; k < count; k += L::width) {
      const R x = value[k];
      const BooleanOf<R> valid = is_valid(x);
      // Samples outside the volume or the field's box count as background. In the field, the change at a face of the
      // box is linear over a voxel, so that the surface of an object that the face cuts has its place on the face.
      if (from_field) {
        const R texel = ratio[k],
                depth = covered.depth(line.origin + (start + static_cast<float>(k) * step) * line.direction);
        const R most = smaller(larger(2.0f * depth, R(-1.0f)), R(1.0f));
        ratio[k] = choose(valid & is_valid(texel), smaller(evidence_of_field(texel), most),
                          choose(depth < kFaceTolerance, most, R(-1.0f)));
      } else {
        ratio[k] = choose(valid, evidence_of(x), R(-1.0f));
      }
      value[k] = choose(valid, share(x), R(NAN));
    }
    lanes.sync();
    if (lanes.lane != 0) return;
    R last = 0;
    for (int k = 0; k < count; ++k) value[k] = last = choose(is_valid(R(value[k])), R(value[k]), last);
    const float edge = m.value<F>(F::edge), nearness = m.value<F>(F::nearness);
    if (from_field) {
      const Crossing<R> crossing = crossing_of<R>(ratio, reach);
      R offset_mm =
          shift_towards_edges(crossing, ratio, value, reach, step_voxels, edge) * step * dot(search.direction, n);
      // The normal may be reversed where the surface lies outside the object. Vertices there follow the field's
      // direction to the object, unless the object lies inwards along the normal and within reach.
      if (!all(crossing.from_inside)) {
        const R back_mm = dot(vector_to_object(v, m, line.origin, static_cast<float>(reach) * step), n);
        const BooleanOf<R> outside = !crossing.from_inside, not_found = !crossing.found;
        offset_mm = choose(outside & (not_found | (back_mm > 0.0f)), back_mm, offset_mm);
      }
      // Share of `hold` that applies: 1 up to one cell from the surface, 0 from two, where `hold` would create folds.
      const R near = smaller(larger(2.0f - fabsf(offset_mm) / m.field.cell_mm, R(0.0f)), R(1.0f));
      store(v.targets_of<EvidenceForce>(), i,
            Vec4Of<R>{offset_mm, 0.0f, 0.0f, near * smaller(larger(2.0f * search.alignment, R(0.0f)), R(1.0f))});
      return;
    }
    R sum = 0, run = 0, evidence = 0;
    using Serial = typename L::Serial;
    auto scores = Serial{}.template scratch<kSamples>(0);
    const PeakOf<R> peak = find_peak(Serial{}, scores, reach, [&](int k) SIMPLEXSEG_INLINED {
      const R half = 0.5f * ratio[k] * step_voxels;
      sum += half;
      run = larger(run + 2.0f * half, R(0.0f));
      evidence = larger(evidence, run);
      const R rise = value[k < 2 * reach ? k + 1 : k] - value[k > 0 ? k - 1 : k];
      // Counts only edges whose inner side is more likely to be object than their outer side.
      const R before = ratio[k > 0 ? k - 1 : k], after = ratio[k < 2 * reach ? k + 1 : k];
      const R counts = choose(before > after, R(1.0f), R(0.0f));
      const int distance = k < reach ? reach - k : k - reach;
      const R score = sum + counts * edge * fabsf(rise) - nearness * distance * step_voxels;
      sum += half;
      return score;
    });
    const R offset = peak.offset();
    // If the line meets no object, the force vanishes and smoothing contracts the surface, since an unreliable normal
    // would drive a reversed patch away from the object. One voxel of evidence 1 on the line gives full confidence.
    const R confidence = smaller(evidence, R(1.0f));
    store(v.targets_of<EvidenceForce>(), i,
          Vec4Of<R>{confidence * offset * step, 0.0f, 0.0f,
                    confidence});  // offset, mm; EvidenceTarget converts it to a position after averaging
  }
};

/// Performs one pass that averages a quantity of each vertex with its three neighbours, from one array into another.
struct AverageOverNeighbours {
  static constexpr const char* name = "average";
  StepView v;
  const Vec4* from;
  Vec4* to;
  int pass;      ///< index of the pass, which only copies for meshes with fewer passes
  bool targets;  ///< true: evidence targets, with the mesh's number of passes; false: local statistics
  template <class I>
  SIMPLEXSEG_HD void operator()(I i) const {
    using R = Real<I>;
    const auto nb = v.neighbours[i];
    const MeshConstants& m = v.meshes[nb.w];
    if (targets ? !(m.forces.weight(ForceId::Evidence) > 0.0f) : !EvidenceForce::uses_local_statistics(m)) return;
    const Vec4Of<R> own = load(from, i);
    if (targets && pass >= m.integer<EvidenceForce>(EvidenceForce::averaging)) {
      store(to, i, own);
      return;
    }
    const Vec4Of<R> a = load(from, nb.x), b = load(from, nb.y), c = load(from, nb.z);
    // Excludes vertices at the surface of the field (w = 1): a neighbour may lie on the other side of a thin part.
    const R share = targets && EvidenceForce::from_field(m.forces) ? 0.25f * (1.0f - own.w) : R(0.25f);
    store(to, i,
          Vec4Of<R>{own.x + share * (a.x + b.x + c.x - 3.0f * own.x), own.y + share * (a.y + b.y + c.y - 3.0f * own.y),
                    own.z + share * (a.z + b.z + c.z - 3.0f * own.z), own.w});
  }
};

/// Converts the averaged offsets (mm along the normal) to targets.
struct EvidenceTarget {
  static constexpr const char* name = "evidence target";
  StepView v;
  const Vec4* offsets;
  template <class I>
  SIMPLEXSEG_HD void operator()(I i) const {
    using R = Real<I>;
    const auto nb = v.neighbours[i];
    const MeshConstants& m = v.meshes[nb.w];
    if (!(m.forces.weight(ForceId::Evidence) > 0.0f)) return;  // the target is already 0
    const Vec4Of<R> offset = load(offsets, i);
    const Vec3Of<R> p = xyz(v.current[i]);
    // A vertex that moves more than an edge length ahead of its neighbours folds the surface. The offset, which applies
    // until the next search, is therefore limited to half an edge length.
    const R bound = EvidenceForce::kMaxEdgesPerSearch * mean_edge_at(v, i);
    // At a fold the normal does not separate inside from outside, so only smoothing acts there.
    const Vec3Of<R> n = xyz(v.frame[i]);
    const R alignment =
        smaller(dot(n, xyz(v.frame[nb.x])), smaller(dot(n, xyz(v.frame[nb.y])), dot(n, xyz(v.frame[nb.z]))));
    R confidence = smaller(larger(2.0f * alignment, R(0.0f)), R(1.0f));
    // Exception: near its surface, the field determines the side, for example at the rim of a thin part.
    if (EvidenceForce::from_field(m.forces))
      confidence += offset.w * (m.value<EvidenceForce>(EvidenceForce::hold) - confidence);
    else
      confidence *= offset.w;
    store(v.targets_of<EvidenceForce>(), i, with_w(p + smaller(larger(offset.x, -bound), bound) * n, confidence));
  }
};

template <class Voxels, int kWidth, class Searches>
void EvidenceForce::find_targets(Searches& searches) {
  const StepView& v = searches.view();
  if (v.local_statistics != nullptr) {
    using Statistics = EvidenceStatistics<Voxels, kWidth>;
    searches.search(Statistics{v, Statistics::kCount});
    searches.average(v.local_statistics, kStatisticsPasses, false);
    static_assert(kStatisticsPasses % 2 == 0, "the last pass writes to the array that is read");
  }
  searches.search(EvidenceSearch<Voxels, kWidth>{v, searches.scratch_floats(id)});
  searches.run(EvidenceTarget{v, searches.average(v.targets_of<EvidenceForce>(), searches.averaging_passes(), true)});
}

}  // namespace simplexseg
