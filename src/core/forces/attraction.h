// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "core/atomics.h"
#include "core/step_view.h"

namespace simplexseg {

/// Attraction points: for each mesh and point C, the nearest vertex P0 and its p-order neighbourhood follow:
///   d_i = w_i (C - P0),   w_i = (1 - t^2)^2 exp(-2 t^2) with t = ring / (p + 1), so w = 1 at P0 and 0 past ring p;
/// several points on one vertex: their weighted mean (docs/mathematics.md, section 2.6).
struct AttractionForce {
  static constexpr ForceId id = ForceId::Attraction;
  static constexpr const char* name = "attraction";
  static constexpr const char* title = "Attraction";
  static constexpr const char* doc = "Pulls the vertex nearest to each attraction point, and its neighbourhood, to the point.";
  enum Parameter : int { weight, order, image_fade, parameter_count };
  static constexpr ParameterInfo parameters[] = {
      {"weight", 2, 0, 20, "", "Strength of the force; 0 leaves it out."},
      {"order", 5, 0, kMaxNeighbourhoodOrder, "rings", "Size of the neighbourhood that follows the nearest vertex.", ParameterKind::Integer},
      {"image_fade", 1, 0, 1, "", "How far image forces fade where a point pulls; 1: the point alone decides at its vertex."},
  };
  static constexpr float stability_bound(const ForceParameters&) { return 1.0f; }

  /// 1 at ring 0, falling smoothly, 0 past ring p.
  SIMPLEXSEG_HD static float ring_weight(int ring, int p) {
    const float t = static_cast<float>(ring) / (p + 1);
    const float taper = 1.0f - t * t;
    return ring > p ? 0.0f : taper * taper * expf(-2.0f * t * t);
  }
};

/// Nearest vertex to each attraction point, over one block of vertices of its mesh. Ties go to the lowest index: the key is
/// the squared distance's bits, then the vertex.
struct FindNearest {
  static constexpr const char* name = "nearest vertex";
  static constexpr int kBlock = 256;
  StepView v;
  int blocks;            ///< for each point: of the largest mesh
  SIMPLEXSEG_HD void operator()(int index) const {
    const int point = index / blocks, block = index % blocks;
    const PointView& c = v.points[point];
    const MeshConstants& m = v.meshes[c.mesh];
    const int first = block * kBlock, last = first + kBlock < m.vertex_count ? first + kBlock : m.vertex_count;
    unsigned long long best = ~0ull;
    for (int k = first; k < last; ++k) {
      const Vec3 d = xyz(v.current[m.first_vertex + k]) - xyz(c.position);
      const float square = dot(d, d);
      const unsigned long long key = static_cast<unsigned long long>(bits_of(square)) << 32 | static_cast<unsigned>(m.first_vertex + k);
      best = key < best ? key : best;
    }
    if (best != ~0ull) atomic_min(&v.nearest[point], best);
  }
};

/// Breadth-first p-order neighbourhood of each point's nearest vertex. One call a point.
struct BindPatch {
  static constexpr const char* name = "attraction patch";
  StepView v;
  SIMPLEXSEG_HD void operator()(int point) const {
    PointView& c = v.points[point];
    PatchEntry* patch = v.patches + static_cast<long>(point) * kMaxPatch;
    const int nearest = static_cast<int>(v.nearest[point] & 0xffffffffu);
    const MeshConstants& m = v.meshes[c.mesh];
    const int order = m.integer<AttractionForce>(AttractionForce::order);
    c.nearest = nearest;
    int count = 0, begin = 0;
    patch[count++] = {nearest, 1.0f};
    for (int ring = 1; ring <= order; ++ring) {
      const int end = count;
      const float w = AttractionForce::ring_weight(ring, order);
      for (int e = begin; e < end; ++e) {
        const Int4 nb = v.neighbours[patch[e].vertex];
        const int candidates[3] = {nb.x, nb.y, nb.z};
        for (int candidate : candidates) {
          bool known = count >= kMaxPatch;
          for (int k = count - 1; k >= 0 && !known; --k) known = patch[k].vertex == candidate;
          if (!known) patch[count++] = {candidate, w};
        }
      }
      begin = end;
    }
    for (int k = count; k < kMaxPatch; ++k) patch[k] = {-1, 0.0f};
  }
};

struct ClearAttraction {
  static constexpr const char* name = "clear attraction";
  StepView v;
  SIMPLEXSEG_HD void operator()(int entry) const {
    const PatchEntry e = v.patches[entry];
    if (e.vertex >= 0) v.attraction[e.vertex] = {0, 0, 0, 0};
  }
};

struct SumAttraction {
  static constexpr const char* name = "sum attraction";
  StepView v;
  SIMPLEXSEG_HD void operator()(int entry) const {
    const PatchEntry e = v.patches[entry];
    if (e.vertex < 0) return;
    const PointView& c = v.points[entry / kMaxPatch];
    // Bounded to 10 m: the sums stay inside 64 bits for any number of points that fits into memory.
    auto fixed = [](float x) { return static_cast<long long>(smaller(larger(x, -1e4f), 1e4f) * kFixedPoint); };
    const Vec3 pull = xyz(c.position) - xyz(v.current[c.nearest]);
    AttractionSum* sum = &v.attraction[e.vertex];
    atomic_add(&sum->weight, fixed(e.weight));
    atomic_add(&sum->x, fixed(e.weight * (e.weight * pull.x)));
    atomic_add(&sum->y, fixed(e.weight * (e.weight * pull.y)));
    atomic_add(&sum->z, fixed(e.weight * (e.weight * pull.z)));
  }
};

}  // namespace simplexseg
