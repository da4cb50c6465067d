// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "core/atomics.h"
#include "forces/lanes.h"
#include "forces/step_view.h"

namespace simplexseg {

/// Attraction points: each point C pulls the nearest vertex P0 of its mesh and the p-order neighbourhood of P0:
///   d_i = w_i (C - P0),   w_i = (1 - t^2)^2 exp(-2 t^2) with t = ring / (p + 1), so w = 1 at P0 and 0 beyond ring p.
/// The displacement of a vertex pulled by several points is the mean of their d_i, weighted by w_i
/// (docs/mathematics.md, section 2.6).
struct AttractionForce {
  static constexpr ForceId id = ForceId::Attraction;
  static constexpr ForceKind kind = ForceKind::External;
  static constexpr const char* name = "attraction";
  static constexpr const char* title = "Attraction";
  static constexpr const char* doc =
      "Pulls the vertex nearest to each attraction point, and its neighbourhood, to the point.";
  enum Parameter : int { weight, order, image_fade, parameter_count };
  static constexpr ParameterInfo parameters[] = {
      {"weight", 2, 0, 20, "", "Strength of the force; 0 disables it."},
      {"order", 5, 0, kMaxNeighbourhoodOrder, "rings", "Size of the neighbourhood that follows the nearest vertex.",
       ParameterKind::Integer},
      {"image_fade", 1, 0, 1, "", "Fading of image forces where a point pulls; 1: only the point acts at its vertex."},
  };
  static constexpr float stability_bound(const ForceParameters&) { return 1.0f; }

  /// Sets `force` to the displacement of vertex i (mm) times the weight of the force, and `image` to the factor that
  /// remains on image forces there; adds the weight to `stiffness`. Resets the sums of the vertex. Leaves the arguments
  /// unchanged where no point pulls.
  SIMPLEXSEG_HD static void apply_pull(const StepView& v, const MeshConstants& m, int i, Vec3& force, float& stiffness,
                                       float& image) {
    if (v.attraction.in_patch[i] == 0) return;
    const AttractionSum s = v.attraction.sums[i];
    v.attraction.sums[i] = {0, 0, 0, 0};
    const float k = m.forces.weight(id);
    if (s.weight == 0 || !(k > 0.0f)) return;
    const float inverse = 1.0f / static_cast<float>(s.weight);
    force = (k * inverse) * Vec3{static_cast<float>(s.x), static_cast<float>(s.y), static_cast<float>(s.z)};
    image = 1.0f - m.value<AttractionForce>(image_fade) * smaller(s.weight * (1.0f / kFixedPoint), 1.0f);
    stiffness += k;
  }
  /// Adds the stiffness of the force at vertex i for the linear model of the multigrid correction, and sets `image` as
  /// in apply_pull(). Leaves the sums unchanged.
  SIMPLEXSEG_HD static void add_stiffness(const StepView& v, const MeshConstants& m, int i, float& stiffness,
                                          float& image) {
    if (v.attraction.in_patch[i] != 0 && m.forces.weight(id) > 0.0f) {
      const float w = smaller(v.attraction.sums[i].weight * (1.0f / kFixedPoint), 1.0f);
      stiffness += m.forces.weight(id) * w;
      image = 1.0f - m.value<AttractionForce>(image_fade) * w;
    }
  }

  /// Weight of a ring: 1 at ring 0, smoothly decreasing, 0 beyond ring p.
  SIMPLEXSEG_HD static float ring_weight(int ring, int p) {
    const float t = static_cast<float>(ring) / (p + 1);
    const float taper = 1.0f - t * t;
    return ring > p ? 0.0f : taper * taper * expf(-2.0f * t * t);
  }
};

/// Finds the nearest vertex to each attraction point of one group, within one block of vertices of the points' mesh.
/// BindPatch computes the minimum over the blocks. The key of a vertex consists of the bits of its squared distance,
/// then its index, so ties go to the lowest index.
struct FindNearest {
  static constexpr const char* name = "nearest vertex";
  static constexpr int kLanes = 32, kBlock = kNearestBlock;
  StepView v;
  template <class L>
  SIMPLEXSEG_HD void operator()(int index, L lanes) const {
    const int group = index % v.attraction.groups, block = index / v.attraction.groups % v.attraction.nearest_blocks;
    const MeshConstants& m = v.meshes[index / v.attraction.groups / v.attraction.nearest_blocks];
    const int begin = block * kBlock, end = begin + kBlock < m.vertex_count ? begin + kBlock : m.vertex_count;
    const int points =
        m.point_count - group * kPointGroup < kPointGroup ? m.point_count - group * kPointGroup : kPointGroup;
    if (begin >= end || points <= 0) return;
    const int first_point = m.first_point + group * kPointGroup, first_vertex = m.first_vertex;
    // Loads all points first, so that the loads overlap.
    Vec3 c[kPointGroup];
    for (int k = 0; k < kPointGroup; ++k) c[k] = xyz(v.attraction.points[first_point + (k < points ? k : 0)].position);
    float best[kPointGroup];
    int nearest[kPointGroup];
    for (int k = 0; k < kPointGroup; ++k) best[k] = INFINITY, nearest[k] = 0;
    // A lane reads every kStride-th position of the block, in batches. Past the end, it reads the last position again.
    constexpr int kStride = L::width, kPerLane = kBlock / kStride, kBatch = kPerLane < 4 ? kPerLane : 4;
    for (int first = 0; first < kPerLane; first += kBatch) {
      Vec3 x[kBatch];
      for (int h = 0; h < kBatch; ++h) {
        const int at = begin + lanes.lane + (first + h) * kStride;
        x[h] = xyz(v.current[first_vertex + (at < end ? at : end - 1)]);
      }
      for (int k = 0; k < kPointGroup; ++k)
        for (int h = 0; h < kBatch; ++h) {
          const Vec3 d = x[h] - c[k];
          const float square = dot(d, d);
          if (square < best[k]) best[k] = square, nearest[k] = first + h;
        }
      if (begin + (first + kBatch) * kStride >= end) break;
    }
    unsigned long long keys[kPointGroup];
    for (int k = 0; k < kPointGroup; ++k) {
      const int at = begin + lanes.lane + nearest[k] * kStride;
      const unsigned vertex = static_cast<unsigned>(first_vertex + (at < end ? at : end - 1)),
                     square = bits_of(best[k]);
      const unsigned smallest = lanes.smallest(square);
      keys[k] = static_cast<unsigned long long>(smallest) << 32 | lanes.smallest(square == smallest ? vertex : ~0u);
    }
    if (lanes.lane != 0) return;
    for (int k = 0; k < points; ++k)
      v.attraction.nearest[static_cast<long>(first_point + k) * v.attraction.nearest_blocks + block] = keys[k];
  }
};

/// Adds the pull of one attraction point to the sums of the vertices of its patch. The sums are integers, so they are
/// independent of the order of the additions. AttractionForce::apply_pull() reads and resets them.
template <class L>
SIMPLEXSEG_HD void add_pull(const StepView& v, int point, Vec3 position, int nearest, int patch_count, L lanes) {
  const PatchEntry* patch = v.attraction.patches + static_cast<long>(point) * kMaxPatch;
  // Limits each term to 10 m, so that the sums at a vertex fit into 64 bits for up to 3 million points.
  auto to_fixed_point = [](float x) { return static_cast<long long>(smaller(larger(x, -1e4f), 1e4f) * kFixedPoint); };
  const Vec3 pull = position - xyz(v.current[nearest]);
  for (int k = lanes.lane; k < patch_count; k += L::width) {
    const PatchEntry e = patch[k];
    AttractionSum* sum = &v.attraction.sums[e.vertex];
    atomic_add(&sum->weight, to_fixed_point(e.weight));
    atomic_add(&sum->x, to_fixed_point(e.weight * (e.weight * pull.x)));
    atomic_add(&sum->y, to_fixed_point(e.weight * (e.weight * pull.y)));
    atomic_add(&sum->z, to_fixed_point(e.weight * (e.weight * pull.z)));
  }
}

/// Finds the p-order neighbourhood (patch) of a point's nearest vertex, breadth first, and adds the pulls of this step.
/// One call per point. The patch contains as many complete rings as fit into kMaxPatch, which is all rings on a mesh of
/// mostly hexagonal cells. The patch is reused while its nearest vertex and its order are unchanged.
struct BindPatch {
  static constexpr const char* name = "attraction patch";
  static constexpr int kLanes = 32;
  StepView v;
  template <class L>
  SIMPLEXSEG_HD void operator()(int point, L lanes) const {
    PointView& c = v.attraction.points[point];
    PatchEntry* patch = v.attraction.patches + static_cast<long>(point) * kMaxPatch;
    const int order = v.meshes[c.mesh].template integer<AttractionForce>(AttractionForce::order);
    // The key of a block beyond the end of the mesh is ~0.
    const unsigned long long* keys = v.attraction.nearest + static_cast<long>(point) * v.attraction.nearest_blocks;
    unsigned long long key = ~0ull;
    SIMPLEXSEG_UNROLL
    for (int b = lanes.lane; b < v.attraction.nearest_blocks; b += L::width) key = keys[b] < key ? keys[b] : key;
    const unsigned square = lanes.smallest(static_cast<unsigned>(key >> 32));
    const int nearest =
        static_cast<int>(lanes.smallest(static_cast<unsigned>(key >> 32) == square ? static_cast<unsigned>(key) : ~0u));
    int count = c.patch_count;
    if (c.nearest != nearest || c.order != order) {
      count = 1;
      if (lanes.lane == 0) patch[0] = {nearest, 1.0f};
      lanes.sync();
      int before = 0, begin = 0;  // first entries of the second-to-last and of the last ring
      for (int ring = 1; ring <= order; ++ring) {
        const int end = count;
        const float w = AttractionForce::ring_weight(ring, order);
        bool fits = true;
        for (int first = 3 * begin; first < 3 * end; first += L::width) {
          const int e = first + lanes.lane;
          int candidate = -1 - lanes.lane;
          bool found = false;
          if (e < 3 * end) {
            const Int4 nb = v.neighbours[patch[e / 3].vertex];
            candidate = e % 3 == 0 ? nb.x : e % 3 == 1 ? nb.y : nb.z;
            found = true;
            for (int k = before; k < count && found; ++k) found = patch[k].vertex != candidate;
          }
          const bool adds = lanes.first_of_equal(candidate) && found;
          const int at = count + lanes.count_before(adds);
          if (adds && at < kMaxPatch) patch[at] = {candidate, w};
          count += lanes.count(adds);
          fits = fits && count <= kMaxPatch;
          count = count < kMaxPatch ? count : kMaxPatch;
          lanes.sync();
        }
        if (!fits) {
          count = end;
          break;
        }
        before = begin, begin = end;
      }
    }
    add_pull(v, point, xyz(c.position), nearest, count, lanes);
    for (int k = lanes.lane; k < count; k += L::width) store_relaxed(&v.attraction.in_patch[patch[k].vertex], 1);
    if (lanes.lane == 0) c.nearest = nearest, c.order = order, c.patch_count = count;
  }
};

/// Adds the pull of each point in steps that do not update the patches. One call per point.
struct SumAttraction {
  static constexpr const char* name = "sum attraction";
  static constexpr int kLanes = 32;
  StepView v;
  template <class L>
  SIMPLEXSEG_HD void operator()(int point, L lanes) const {
    const PointView& c = v.attraction.points[point];
    add_pull(v, point, xyz(c.position), c.nearest, c.patch_count, lanes);
  }
};

}  // namespace simplexseg
