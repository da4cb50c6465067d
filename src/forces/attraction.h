// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "core/atomics.h"
#include "forces/lanes.h"
#include "forces/step_view.h"

namespace simplexseg {

/// Attraction points: for each mesh and point C, the nearest vertex P0 and its p-order neighbourhood follow:
///   d_i = w_i (C - P0),   w_i = (1 - t^2)^2 exp(-2 t^2) with t = ring / (p + 1), so w = 1 at P0 and 0 past ring p;
/// several points on one vertex: their weighted mean (docs/mathematics.md, section 2.6).
struct AttractionForce {
  static constexpr ForceId id = ForceId::Attraction;
  static constexpr ForceKind kind = ForceKind::External;
  static constexpr const char* name = "attraction";
  static constexpr const char* title = "Attraction";
  static constexpr const char* doc =
      "Pulls the vertex nearest to each attraction point, and its neighbourhood, to the point.";
  enum Parameter : int { weight, order, image_fade, parameter_count };
  static constexpr ParameterInfo parameters[] = {
      {"weight", 2, 0, 20, "", "Strength of the force; 0 leaves it out."},
      {"order", 5, 0, kMaxNeighbourhoodOrder, "rings", "Size of the neighbourhood that follows the nearest vertex.",
       ParameterKind::Integer},
      {"image_fade", 1, 0, 1, "",
       "How far image forces fade where a point pulls; 1: the point alone decides at its vertex."},
  };
  static constexpr float stability_bound(const ForceParameters&) { return 1.0f; }

  /// Takes what the sums of the points say to vertex i, and leaves zeros: sets the force, its weight included, adds to
  /// the stiffness of the vertex, and says what is left of the image forces there.
  SIMPLEXSEG_HD static void take_pull(const StepView& v, const MeshConstants& m, int i, Vec3& force, float& stiffness,
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
  /// The same for the linear model of the multigrid correction, which leaves the sums as they are: adds the share of
  /// the bound that the force has at vertex i to `stiffness`, and says what is left of the image forces.
  SIMPLEXSEG_HD static void add_stiffness(const StepView& v, const MeshConstants& m, int i, float& stiffness,
                                          float& image) {
    if (v.attraction.in_patch[i] != 0 && m.forces.weight(id) > 0.0f) {
      const float w = smaller(v.attraction.sums[i].weight * (1.0f / kFixedPoint), 1.0f);
      stiffness += m.forces.weight(id) * w;
      image = 1.0f - m.value<AttractionForce>(image_fade) * w;
    }
  }

  /// 1 at ring 0, falling smoothly, 0 past ring p.
  SIMPLEXSEG_HD static float ring_weight(int ring, int p) {
    const float t = static_cast<float>(ring) / (p + 1);
    const float taper = 1.0f - t * t;
    return ring > p ? 0.0f : taper * taper * expf(-2.0f * t * t);
  }
};

/// Nearest vertex to each attraction point, first half: over one block of vertices of a mesh, for one group of points
/// of that mesh. BindPatch takes the smallest of the blocks' keys. Ties go to the lowest index: the key is the squared
/// distance's bits, then the vertex.
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
    // All loads first: none waits for another.
    Vec3 c[kPointGroup];
    for (int k = 0; k < kPointGroup; ++k) c[k] = xyz(v.attraction.points[first_point + (k < points ? k : 0)].position);
    float best[kPointGroup];
    int nearest[kPointGroup];
    for (int k = 0; k < kPointGroup; ++k) best[k] = INFINITY, nearest[k] = 0;
    // A lane holds every kStride-th position of the block, the last one in place of those past the end.
    constexpr int kStride = L::width, kOwn = kBlock / kStride, kHeld = kOwn < 4 ? kOwn : 4;
    for (int held = 0; held < kOwn; held += kHeld) {
      Vec3 x[kHeld];
      for (int h = 0; h < kHeld; ++h) {
        const int at = begin + lanes.lane + (held + h) * kStride;
        x[h] = xyz(v.current[first_vertex + (at < end ? at : end - 1)]);
      }
      for (int k = 0; k < kPointGroup; ++k)
        for (int h = 0; h < kHeld; ++h) {
          const Vec3 d = x[h] - c[k];
          const float square = dot(d, d);
          if (square < best[k]) best[k] = square, nearest[k] = held + h;
        }
      if (begin + (held + kHeld) * kStride >= end) break;
    }
    unsigned long long keys[kPointGroup];
    for (int k = 0; k < kPointGroup; ++k) {
      const int at = begin + lanes.lane + nearest[k] * kStride;
      const unsigned vertex = static_cast<unsigned>(first_vertex + (at < end ? at : end - 1)),
                     square = bits_of(best[k]);
      const unsigned least = lanes.smallest(square);
      keys[k] = static_cast<unsigned long long>(least) << 32 | lanes.smallest(square == least ? vertex : ~0u);
    }
    if (lanes.lane != 0) return;
    for (int k = 0; k < points; ++k)
      v.attraction.nearest[static_cast<long>(first_point + k) * v.attraction.nearest_blocks + block] = keys[k];
  }
};

/// Adds what one attraction point says to the sums of the vertices of its patch; integers, so that their order does not
/// matter. The integration takes the sums and leaves zeros.
template <class L>
SIMPLEXSEG_HD void add_pull(const StepView& v, int point, Vec3 position, int nearest, int patch_count, L lanes) {
  const PatchEntry* patch = v.attraction.patches + static_cast<long>(point) * kMaxPatch;
  // Bounded to 10 m: the sums stay inside 64 bits for any number of points that fits into memory.
  auto fixed = [](float x) { return static_cast<long long>(smaller(larger(x, -1e4f), 1e4f) * kFixedPoint); };
  const Vec3 pull = position - xyz(v.current[nearest]);
  for (int k = lanes.lane; k < patch_count; k += L::width) {
    const PatchEntry e = patch[k];
    AttractionSum* sum = &v.attraction.sums[e.vertex];
    atomic_add(&sum->weight, fixed(e.weight));
    atomic_add(&sum->x, fixed(e.weight * (e.weight * pull.x)));
    atomic_add(&sum->y, fixed(e.weight * (e.weight * pull.y)));
    atomic_add(&sum->z, fixed(e.weight * (e.weight * pull.z)));
  }
}

/// Breadth-first p-order neighbourhood of each point's nearest vertex, and the first sums over it: as many whole rings
/// as kMaxPatch has room for, which are all on any surface of a sphere's kind. One call a point. A neighbourhood that
/// is still the right one is kept.
struct BindPatch {
  static constexpr const char* name = "attraction patch";
  static constexpr int kLanes = 32;
  StepView v;
  template <class L>
  SIMPLEXSEG_HD void operator()(int point, L lanes) const {
    PointView& c = v.attraction.points[point];
    PatchEntry* patch = v.attraction.patches + static_cast<long>(point) * kMaxPatch;
    const int order = v.meshes[c.mesh].template integer<AttractionForce>(AttractionForce::order);
    // Where the mesh has fewer blocks than the largest one, the rest is ~0.
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
      int before = 0, begin = 0;  // of the last ring but one, and of the last ring
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
