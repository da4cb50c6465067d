// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "forces/line_search.h"
#include "forces/region_model.h"

namespace simplexseg {

/// Draws a mesh to its object: along the normal, the boundary goes where most evidence for the object lies inside of it
/// and most evidence for the background outside. With the evidence l in [-1, 1] of each sample,
///   score(j) = sum_{i<j} l_i s + g |dI/dn| - c |j| s,   d = s argmax score
/// (docs/mathematics.md, section 2.5). The evidence is the mesh's field P(object), learned from the user's marks
/// (src/evidence/); or the log-likelihood ratio of intensities in the mesh's region model (src/forces/region_model.h)
/// and, near the end, of those found just inside and outside of the surface nearby. Targets are averaged over
/// neighbours, so that the surface moves as a sheet.
struct EvidenceForce {
  static constexpr ForceId id = ForceId::Evidence;
  static constexpr ForceKind kind = ForceKind::Image;
  static constexpr const char *targets_name = "evidence targets", *search_name = "evidence search";
  static constexpr const char* name = "evidence";
  static constexpr const char* title = "Evidence";
  static constexpr float kEdgesAtOnce = 0.5f;
  static constexpr const char* doc = "Draws the mesh to the surface of its object, which is learned from the marks.";
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
      {"weight", 0.5f, 0, 10, "", "Strength of the force; 0 leaves it out."},
      {"reach", 2.0f, 0.5f, 10, "edges",
       "How far to each side is searched, in mean edge lengths (of the vertex in a field, else of the mesh when it was "
       "made or refined); at least 2.5 voxels."},
      {"samples", 8, 2, kMaxSearch, "", "Samples to each side.", ParameterKind::Integer},
      {"edge", 2.0f, 0, 10, "", "Weight of the image gradient against the evidence."},
      {"nearness", 0.2f, 0, 2, "",
       "How much a near boundary is preferred to a far one; of the source 'intensities' alone."},
      {"local", 0.3f, 0, 1, "",
       "Share of the evidence that intensities near by give, on the finest level; of the source 'intensities' alone."},
      {"averaging", 2, 0, 8, "", "How often the targets are averaged over neighbours.", ParameterKind::Integer},
      {"pull", 2, 0, 20, "voxel", "Bound of the displacement; 0: none."},
      {"balloon", 0, -1, 1, "", "Added to the evidence of every sample: above 0 grows the mesh, below 0 shrinks it."},
      {"source", 0, 0, 1, "",
       "What says where the object is: the field that is learned from the marks, or what intensities the seed has "
       "inside and around it.",
       ParameterKind::Choice, "field|intensities"},
      {"hold", 8, 1, 20, "",
       "How many times as strong the force is where the surface lies near that of the field and faces the same way."},
  };
  static constexpr bool from_field(const ForceParameters& p) { return p.integer(id, source) == 0; }
  /// Whether it looks at the intensities on either side of the surface, once the mesh is on its finest level.
  static constexpr bool compares_locally(const ForceParameters& p) {
    return !from_field(p) && p.values[static_cast<int>(id)][local] > 0;
  }
  /// Whether intensities near by count for a mesh now.
  SIMPLEXSEG_HD static bool takes_statistics(const MeshConstants& m) {
    return m.finest != 0 && m.forces.weight(id) > 0.0f && m.integer<EvidenceForce>(source) != 0 &&
           m.value<EvidenceForce>(local) > 0.0f;
  }
  /// A mesh without a field has no evidence.
  static constexpr bool has_reference(const ForceParameters& p, const RecordedReferences& recorded) {
    return !from_field(p) || recorded.field;
  }
  static constexpr float stability_bound(const ForceParameters& p) {
    return from_field(p) ? p.values[static_cast<int>(id)][hold] : 1.0f;
  }
  /// Floats that a search keeps at hand: samples and ratios.
  static constexpr int scratch_floats(const ForceParameters& p) { return 2 * (2 * p.integer(id, samples) + 1); }
  /// Samples of the volume that a search takes, for the plan.
  static constexpr int samples_of_search(const ForceParameters& p) { return 2 * p.integer(id, samples) + 1; }
  /// Runs what finds the targets.
  template <class Voxels, int kWidth, class Searches>
  static void find_targets(Searches& searches);

  /// How strong the force is at this vertex, next to its weight.
  SIMPLEXSEG_HD static float trust(const StepView& v, int i) { return v.targets_of<EvidenceForce>()[i].w; }
  SIMPLEXSEG_HD static Vec3 displacement(const StepView& v, const MeshConstants& m, int i, Int4, Vec3 p, Vec4 frame) {
    return pull_to_target(v.targets_of<EvidenceForce>()[i], p, xyz(frame), m.value<EvidenceForce>(pull) * m.voxel_mm);
  }
  SIMPLEXSEG_HD static float search_step_mm(const MeshConstants& m, float edge_mm) {
    return larger(m.value<EvidenceForce>(reach) * edge_mm, 2.5f * m.voxel_mm) / m.integer<EvidenceForce>(samples);
  }
};

/// Mean length of the three edges of a vertex, mm.
SIMPLEXSEG_HD float mean_edge_at(const StepView& v, int i) {
  const Int4 nb = v.neighbours[i];
  const Vec3 p = xyz(v.current[i]);
  return (norm(xyz(v.current[nb.x]) - p) + norm(xyz(v.current[nb.y]) - p) + norm(xyz(v.current[nb.z]) - p)) / 3.0f;
}

/// P(object) from which on a sample is full evidence: (1 + 1/gain) / 2.
inline constexpr float kFieldGain = 2;
/// Change of P(object) from voxel to voxel below which it says nothing of where the surface is.
inline constexpr float kFlatField = 0.02f;

/// The field of a mesh as a volume of its own, the first voxel of its box at index 0.
SIMPLEXSEG_HD VolumeView field_view(const StepView& v, const MeshConstants& m) {
  VolumeView view = v.volume;
  view.voxels = v.fields + m.field.offset;
  for (int a = 0; a < 3; ++a) view.size[a] = m.field.size[a];
  return view;
}

/// From a voxel index position where P is about 0, the way (mm, at most `most_mm`) towards the object of the mesh's
/// field.
SIMPLEXSEG_HD Vec3 way_to_object(const StepView& v, const MeshConstants& m, Vec3 at, float most_mm) {
  const VolumeView field = field_view(v, m);
  Vec3 p = at - m.field.first_voxel();
  // Beyond the box: from its nearest place.
  p = {smaller(larger(p.x, 0.0f), m.field.size[0] - 1.0f), smaller(larger(p.y, 0.0f), m.field.size[1] - 1.0f),
       smaller(larger(p.z, 0.0f), m.field.size[2] - 1.0f)};
  const Cell c = cell_at(field, p);
  const Corners q = LinearVoxels<std::uint16_t>(field).corners(c);
  const Vec3 rise = gradient(field, q, c);
  const float size = norm(rise), away_voxels = larger(kFieldFloor - interpolate(q, c), 0.0f) / kFieldFall;
  return size > 0.0f ? (smaller((away_voxels + 1.0f) * m.voxel_mm, most_mm) / size) * rise : Vec3{0, 0, 0};
}

/// How much the way out of the object counts next to the normal, where a line is laid through the field's surface.
inline constexpr float kLean = 4;

/// A line through the surface of a field: the normal n, leant towards the way out of the object where the two agree; on
/// thin parts and where vertices are few normals alone are too rough. `agree`: n with the way out, -1 to 1; 0 where the
/// field is flat.
struct SearchLine {
  Vec3 direction;
  float agree;
};
SIMPLEXSEG_HD SearchLine line_through(const StepView& v, const MeshConstants& m, Vec3 at, Vec3 n) {
  const VolumeView field = field_view(v, m);
  const Cell c = cell_at(field, at - m.field.first_voxel());
  const Vec3 fall = -1.0f * gradient(field, LinearVoxels<std::uint16_t>(field).corners(c), c);
  const float size = norm(fall);
  if (!(size > 0.0f)) return {n, 0.0f};
  // Where the field is nearly flat less is made of its direction, the flatter it is.
  const float agree = smaller(size * m.voxel_mm / (kFlatField * kFieldScale), 1.0f) * dot(fall, n) / size;
  const Vec3 leant = n + (kLean * larger(agree, 0.0f) / size) * fall;
  return {(1.0f / norm(leant)) * leant, agree};
}

/// Where the evidence changes along a line, seen from its middle.
struct Crossing {
  float shift;       ///< samples from the middle
  bool found;        ///< false: nowhere in reach
  bool from_inside;  ///< the middle lies in the object: looked for outwards, else inwards
};
template <class Ratios>
SIMPLEXSEG_HD Crossing crossing_of(Ratios& ratio, int reach) {
  auto between = [&](int k) { return k + ratio[k] / (ratio[k] - ratio[k + 1]) - reach; };
  if (ratio[reach] > 0.0f) {
    for (int k = reach; k < 2 * reach; ++k)
      if (!(ratio[k + 1] > 0.0f)) return {between(k), true, true};
    return {static_cast<float>(reach), false, true};
  }
  for (int k = reach - 1; k >= 0; --k)
    if (ratio[k] > 0.0f) return {between(k), true, false};
  return {static_cast<float>(-reach), false, false};
}

/// The crossing, drawn to the edges of the image that lie within a voxel of it where the field is in doubt; samples.
template <class Ratios, class Values>
SIMPLEXSEG_HD float near_edges(Crossing crossing, Ratios& ratio, Values& value, int reach, float step_voxels,
                               float edge) {
  if (!crossing.found) return crossing.shift;
  float sum = crossing.shift, weights = 1;
  for (int k = 1; k < 2 * reach; ++k) {
    const float shift = static_cast<float>(k - reach), away = fabsf(shift - crossing.shift) * step_voxels;
    const float weight = away < 1.0f ? edge * (1.0f - ratio[k] * ratio[k]) * fabsf(value[k + 1] - value[k - 1]) : 0.0f;
    sum += weight * shift, weights += weight;
  }
  return sum / weights;
}

/// How often local statistics are averaged over neighbours.
inline constexpr int kStatisticsPasses = 4;

/// Mean intensities (in shares of the range) just inside and just outside of the surface: x, y; z: their mean variance.
template <class Voxels, int kWidth>
struct EvidenceStatistics {
  static constexpr const char* name = "evidence statistics";
  static constexpr int kSamples = 4;  ///< to each side, a voxel apart, starting a voxel away from the surface
  static constexpr int kLanes = kWidth, kCount = 2 * kSamples + 1;
  StepView v;
  int scratch;  ///< floats: kCount
  template <class L>
  SIMPLEXSEG_HD void operator()(int i, L lanes) const {
    const MeshConstants& m = v.meshes[v.neighbours[i].w];
    if (!EvidenceForce::takes_statistics(m)) return;
    const IndexLine line = index_line(v.volume, xyz(v.current[i]), xyz(v.frame[i]));
    float mean[2], variance = 0, count = 0;
    auto values = lanes.template scratch<kCount>(0);
    sample_line(Voxels(v.volume), v.volume, lanes, line, -kSamples * m.voxel_mm, m.voxel_mm, kCount, values);
    if (lanes.lane != 0) return;
    for (int side = 0; side < 2; ++side) {
      float sum = 0, square = 0, n = 0;
      for (int j = 1; j <= kSamples; ++j) {
        const float value = (values[side == 0 ? kSamples - j : kSamples + j] - m.intensity_low) * m.intensity_scale;
        if (is_valid(value)) sum += value, square += value * value, n += 1.0f;
      }
      mean[side] = n > 0.0f ? sum / n : 0.0f;
      variance += n > 0.0f ? square - n * mean[side] * mean[side] : 0.0f;
      count += n;
    }
    v.local_statistics[i] = {mean[0], mean[1], count > 0.0f ? larger(variance, 0.0f) / count : 0.0f, 0.0f};
  }
};

template <class Voxels, int kWidth>
struct EvidenceSearch {
  static constexpr const char* name = EvidenceForce::search_name;
  static constexpr int kSamples = 2 * kMaxSearch + 1;
  static constexpr int kLanes = kWidth;
  StepView v;
  int scratch;  ///< floats: samples and ratios of the longest search
  template <class L>
  SIMPLEXSEG_HD void operator()(int i, L lanes) const {
    using F = EvidenceForce;
    const MeshConstants& m = v.meshes[v.neighbours[i].w];
    if (!(m.forces.weight(ForceId::Evidence) > 0.0f)) {
      if (lanes.lane == 0) v.targets_of<EvidenceForce>()[i] = {0, 0, 0, 0};
      return;
    }
    const bool from_field = F::from_field(m.forces);
    const int reach = m.integer<F>(F::samples);
    const float step = F::search_step_mm(m, from_field ? mean_edge_at(v, i) : m.edge_mm),
                step_voxels = step / m.voxel_mm;
    IndexLine line = index_line(v.volume, xyz(v.current[i]), xyz(v.frame[i]));
    SearchLine search{xyz(v.frame[i]), 0};
    if (from_field) {
      search = line_through(v, m, line.origin, search.direction);
      line.direction = rotate_to_index(v.volume, search.direction);
    }
    const float* table = m.region_table >= 0 ? v.region_tables + m.region_table : nullptr;
    const float balloon = m.value<F>(F::balloon);
    float local = 0, middle = 0, slope = 0;
    if (v.local_statistics && m.finest && !from_field) {
      local = m.value<F>(F::local);
      const Vec4 s = v.local_statistics[i];
      const float contrast = s.x - s.y;
      middle = 0.5f * (s.x + s.y);
      // Ratio of two Gaussians of one variance, bounded below so that a flat neighbourhood says nothing.
      slope = contrast / (s.z + 0.25f * contrast * contrast + 1e-4f);
    }
    auto share = [&](float intensity) {
      return smaller(larger((intensity - m.intensity_low) * m.intensity_scale, 0.0f), 1.0f);
    };
    auto evidence_of = [&](float intensity) {
      const float x = share(intensity);
      float l = table ? table[static_cast<int>(x * (kRegionBins - 1) + 0.5f)] : 0.0f;
      if (local > 0.0f) l = (1.0f - local) * l + local * smaller(larger((x - middle) * slope, -1.0f), 1.0f);
      return smaller(larger(l + balloon, -1.0f), 1.0f);
    };
    auto evidence_of_field = [&](float texel) {
      const float p = texel * (1.0f / kFieldScale);
      return smaller(larger(kFieldGain * (2.0f * p - 1.0f) + balloon, -1.0f), 1.0f);
    };
    const int count = 2 * reach + 1;
    auto value = lanes.template scratch<kSamples>(0);
    auto ratio = lanes.template scratch<kSamples>(count);
    sample_line(Voxels(v.volume), v.volume, lanes, line, -reach * step, step, count, value);
    if (from_field) {
      const VolumeView field = field_view(v, m);
      const IndexLine in_box{line.origin - m.field.first_voxel(), line.direction};
      sample_line(LinearVoxels<std::uint16_t>(field), field, lanes, in_box, -reach * step, step, count, ratio);
    }
    for (int k = lanes.lane; k < count; k += L::width) {
      const bool valid = is_valid(value[k]);
      // There is no object outside of the volume, nor of the field's box.
      if (from_field)
        ratio[k] = valid && is_valid(ratio[k]) ? evidence_of_field(ratio[k]) : -1.0f;
      else
        ratio[k] = valid ? evidence_of(value[k]) : -1.0f;
      value[k] = valid ? share(value[k]) : NAN;
    }
    lanes.sync();
    if (lanes.lane != 0) return;
    for (int k = 0; k < count; ++k) value[k] = is_valid(value[k]) ? value[k] : k > 0 ? value[k - 1] : 0.0f;
    const float edge = m.value<F>(F::edge), nearness = m.value<F>(F::nearness);
    if (from_field) {
      const Crossing crossing = crossing_of(ratio, reach);
      float offset_mm =
          near_edges(crossing, ratio, value, reach, step_voxels, edge) * step * dot(search.direction, xyz(v.frame[i]));
      // A surface that lies outside of the object may be turned inside out: what says where to go is the way back, not
      // the normal, but where the two agree and the object is in sight.
      if (!crossing.from_inside) {
        const float back_mm = dot(way_to_object(v, m, line.origin, reach * step), xyz(v.frame[i]));
        if (!crossing.found || back_mm > 0.0f) offset_mm = back_mm;
      }
      // Within a voxel of the surface, less up to two: from afar the force stays as weak as it is for folds.
      const float near = smaller(larger(2.0f - fabsf(offset_mm) / m.voxel_mm, 0.0f), 1.0f);
      v.targets_of<EvidenceForce>()[i] = {offset_mm, 0, 0, near * smaller(larger(2.0f * search.agree, 0.0f), 1.0f)};
      return;
    }
    float sum = 0, run = 0, evidence = 0;
    auto kept = OneLane{}.scratch<kSamples>(0);
    const Peak peak = find_peak(OneLane{}, kept, reach, [&](int k) {
      const float half = 0.5f * ratio[k] * step_voxels;
      sum += half;
      run = larger(run + 2.0f * half, 0.0f);
      evidence = larger(evidence, run);
      const float rise = value[k < 2 * reach ? k + 1 : k] - value[k > 0 ? k - 1 : k];
      // The object side of the edge is the likelier side: only edges that agree with the evidence count.
      const float before = ratio[k > 0 ? k - 1 : k], after = ratio[k < 2 * reach ? k + 1 : k];
      const float agree = before > after ? 1.0f : 0.0f;
      const int distance = k < reach ? reach - k : k - reach;
      const float score = sum + agree * edge * fabsf(rise) - nearness * distance * step_voxels;
      sum += half;
      return score;
    });
    const float offset = peak.offset(reach);
    // Where the line meets no object, the normal may point anywhere (a patch that was turned inside out would be driven
    // away for ever): the image then says nothing, and smoothing draws the surface together. One voxel of object is
    // full evidence.
    const float trust = smaller(evidence, 1.0f);
    v.targets_of<EvidenceForce>()[i] = {trust * offset * step, 0, 0,
                                        trust};  // as an offset, until averaged: EvidenceTarget makes it a position
  }
};

/// One pass of averaging a per-vertex quantity with the three neighbours, from one array into another.
struct AverageOverNeighbours {
  static constexpr const char* name = "average";
  StepView v;
  const Vec4* from;
  Vec4* to;
  int pass;      ///< done only for meshes that want more passes than this
  bool targets;  ///< evidence targets (as many passes as the mesh asks for), else statistics
  SIMPLEXSEG_HD void operator()(int i) const {
    const Int4 nb = v.neighbours[i];
    const MeshConstants& m = v.meshes[nb.w];
    if (targets ? !(m.forces.weight(ForceId::Evidence) > 0.0f) : !EvidenceForce::takes_statistics(m)) return;
    const Vec4 own = from[i];
    if (targets && pass >= m.integer<EvidenceForce>(EvidenceForce::averaging)) {
      to[i] = own;
      return;
    }
    const Vec4 a = from[nb.x], b = from[nb.y], c = from[nb.z];
    // What the field holds keeps its own target: on thin parts a neighbour's may belong to the other side.
    const float share = targets && EvidenceForce::from_field(m.forces) ? 0.25f * (1.0f - own.w) : 0.25f;
    to[i] = {own.x + share * (a.x + b.x + c.x - 3.0f * own.x), own.y + share * (a.y + b.y + c.y - 3.0f * own.y),
             own.z + share * (a.z + b.z + c.z - 3.0f * own.z), own.w};
  }
};

/// Makes the averaged offsets into targets.
struct EvidenceTarget {
  static constexpr const char* name = "evidence target";
  StepView v;
  const Vec4* offsets;
  SIMPLEXSEG_HD void operator()(int i) const {
    const Int4 nb = v.neighbours[i];
    const MeshConstants& m = v.meshes[nb.w];
    if (!(m.forces.weight(ForceId::Evidence) > 0.0f)) return;  // its target says so
    const Vec4 offset = offsets[i];
    const Vec3 p = xyz(v.current[i]);
    // A vertex that runs ahead of its neighbours by more than an edge folds the surface: half an edge until the next
    // search.
    const float bound = EvidenceForce::kEdgesAtOnce * mean_edge_at(v, i);
    // On a fold the normal says nothing of inside and outside: there smoothing acts alone.
    const Vec3 n = xyz(v.frame[i]);
    const float agree =
        smaller(dot(n, xyz(v.frame[nb.x])), smaller(dot(n, xyz(v.frame[nb.y])), dot(n, xyz(v.frame[nb.z]))));
    float trust = smaller(larger(2.0f * agree, 0.0f), 1.0f);
    // ... unless the field does, as at the rim of a thin part.
    if (EvidenceForce::from_field(m.forces))
      trust += offset.w * (m.value<EvidenceForce>(EvidenceForce::hold) - trust);
    else
      trust *= offset.w;
    v.targets_of<EvidenceForce>()[i] = with_w(p + smaller(larger(offset.x, -bound), bound) * n, trust);
  }
};

template <class Voxels, int kWidth, class Searches>
void EvidenceForce::find_targets(Searches& searches) {
  const StepView& v = searches.view();
  if (v.local_statistics != nullptr) {
    using Statistics = EvidenceStatistics<Voxels, kWidth>;
    searches.search(Statistics{v, Statistics::kCount});
    searches.average(v.local_statistics, kStatisticsPasses, false);
    static_assert(kStatisticsPasses % 2 == 0, "so that the averages end where they are read");
  }
  searches.search(EvidenceSearch<Voxels, kWidth>{v, searches.scratch_floats(id)});
  searches.run(EvidenceTarget{v, searches.average(v.targets_of<EvidenceForce>(), searches.averaging_passes(), true)});
}

}  // namespace simplexseg
