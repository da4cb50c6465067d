// SPDX-License-Identifier: Apache-2.0
// The multigrid correction: one V-cycle on a linear model of the forces turns the force f of each vertex into a step z that
// moves slow modes as far as fast ones (docs/mathematics.md, section 3). The model is  A = k L + E: L the graph Laplacian of
// the mesh, k half the bound of the internal forces, E what image and attraction hold a vertex with. It changes how fast the
// fixed point is reached, never where it lies.
#pragma once
#include "core/force_list.h"
#include "core/step_view.h"

namespace simplexseg {

/// The linear system of one vertex of one level, 3 x 3: (degree k) I + E.
struct VertexSystem {
  float xx, xy, xz, yy, yz, zz;
  SIMPLEXSEG_HD VertexSystem(Vec4 a, Vec4 b, float diagonal) : xx(a.x + diagonal), xy(a.y), xz(a.z), yy(a.w + diagonal), yz(b.x), zz(b.y + diagonal) {}
  SIMPLEXSEG_HD Vec3 times(Vec3 v) const {
    return {xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z};
  }
  SIMPLEXSEG_HD Vec3 solve(Vec3 r) const {
    const float a = yy * zz - yz * yz, b = xz * yz - xy * zz, c = xy * yz - xz * yy;
    const float d = xx * zz - xz * xz, e = xy * xz - xx * yz, f = xx * yy - xy * xy;
    const float determinant = xx * a + xy * b + xz * c;
    const float inverse = determinant > 1e-37f ? 1.0f / determinant : 0.0f;
    return inverse * Vec3{a * r.x + b * r.y + c * r.z, b * r.x + d * r.y + e * r.z, c * r.x + e * r.y + f * r.z};
  }
};
/// Share of a Jacobi step that smooths.
inline constexpr float kRelaxation = 0.7f;

/// E of each vertex of the mesh: of an image force k c n n^T, of attraction k w I.
template <unsigned kMask>
struct LocalStiffness {
  static constexpr const char* name = "stiffness";
  StepView v;
  SIMPLEXSEG_HD void operator()(int i) const {
    const MeshConstants& m = v.meshes[v.neighbours[i].w];
    float along = 0, all = m.hold * m.model, image = 1;
    if constexpr ((kMask & bit(ForceId::Attraction)) != 0) {
      if (v.attracted[i] != 0 && m.forces.weight(ForceId::Attraction) > 0.0f) {
        const float w = smaller(v.attraction[i].weight * (1.0f / kFixedPoint), 1.0f);
        all += m.forces.weight(ForceId::Attraction) * w;
        image = 1.0f - m.value<AttractionForce>(AttractionForce::image_fade) * w;
      }
    }
    if constexpr ((kMask & bit(ForceId::Gradient)) != 0) along += m.forces.weight(ForceId::Gradient) * v.gradient_target[i].w;
    if constexpr ((kMask & bit(ForceId::IntensityProfile)) != 0) along += m.forces.weight(ForceId::IntensityProfile) * v.profile_target[i].w;
    if constexpr ((kMask & bit(ForceId::Region)) != 0) along += m.forces.weight(ForceId::Region) * v.region_target[i].w;
    along *= image;
    const Vec3 n = xyz(v.frame[i]), an = along * n;
    v.levels.stiffness_a[i] = {an.x * n.x + all, an.x * n.y, an.x * n.z, an.y * n.y + all};
    v.levels.stiffness_b[i] = {an.y * n.z, an.z * n.z + all, 0, 0};
  }
};

/// E of each vertex of a coarser level: the sum over what it stands for.
struct CoarseStiffness {
  static constexpr const char* name = "coarse stiffness";
  static constexpr int kLanes = 32;
  StepView v;
  int first;              ///< vertex of the level, counted over all levels
  template <class L>
  SIMPLEXSEG_HD void operator()(int index, L lanes) const {
    const LevelsView& l = v.levels;
    const CoarseRow* row = l.rows + (first + index - v.vertex_count);
    Vec4 a{0, 0, 0, 0}, b{0, 0, 0, 0};
    for (int p = row[0].first_part + lanes.lane; p < row[1].first_part; p += L::width) {
      const Vec4 x = l.stiffness_a[l.parts[p]], y = l.stiffness_b[l.parts[p]];
      a = {a.x + x.x, a.y + x.y, a.z + x.z, a.w + x.w}, b = {b.x + y.x, b.y + y.y, 0, 0};
    }
    a = {lanes.sum(a.x), lanes.sum(a.y), lanes.sum(a.z), lanes.sum(a.w)}, b = {lanes.sum(b.x), lanes.sum(b.y), 0, 0};
    if (lanes.lane == 0) l.stiffness_a[first + index] = a, l.stiffness_b[first + index] = b;
  }
};

/// First half of the cycle on the mesh: a Jacobi step from 0.
SIMPLEXSEG_HD void begin_cycle(const StepView& v, const MeshConstants& m, int i, Vec3 force) {
  const LevelsView& l = v.levels;
  l.residual[i] = with_w(force, 0.0f);
  l.correction[i] = with_w(kRelaxation * VertexSystem(l.stiffness_a[i], l.stiffness_b[i], m.model).solve(force), 0.0f);
}

/// Sums what is left of the residual onto the next coarser level, and takes the Jacobi step there. Small levels are all
/// waiting for memory: there the parts of a vertex are shared out among lanes.
template <bool kFromMesh>
struct Restrict {
  static constexpr const char* name = "restrict";
  static constexpr int kLanes = kFromMesh ? 1 : 32;
  StepView v;
  int first;
  static constexpr int scratch = 0;
  template <class L>
  SIMPLEXSEG_HD void operator()(int index, L lanes) const {
    const LevelsView& l = v.levels;
    const CoarseRow* row = l.rows + (first + index - v.vertex_count);
    const float k = v.meshes[row->mesh].model;
    Vec3 sum{0, 0, 0};
    for (int p = row[0].first_part + lanes.lane; p < row[1].first_part; p += L::width) {
      const int i = l.parts[p];
      float degree = 1;
      Vec3 beside{0, 0, 0};
      if constexpr (kFromMesh) {
        const Int4 nb = v.neighbours[i];
        beside = (1.0f / 3.0f) * (xyz(l.correction[nb.x]) + xyz(l.correction[nb.y]) + xyz(l.correction[nb.z]));
      } else {
        const CoarseRow* fine = l.rows + (i - v.vertex_count);
        degree = fine->degree;
        SIMPLEXSEG_UNROLL
        for (int e = fine[0].first_edge; e < fine[1].first_edge; ++e) beside = beside + l.edges[e].conductance * xyz(l.correction[l.edges[e].to]);
      }
      const VertexSystem system(l.stiffness_a[i], l.stiffness_b[i], k * degree);
      sum = sum + (xyz(l.residual[i]) - (system.times(xyz(l.correction[i])) - k * beside));
    }
    sum = {lanes.sum(sum.x), lanes.sum(sum.y), lanes.sum(sum.z)};
    if (lanes.lane != 0) return;
    const bool last = row[0].first_edge == row[1].first_edge;      // a whole mesh, or part of one: solved exactly
    const VertexSystem system(l.stiffness_a[first + index], l.stiffness_b[first + index], k * row->degree);
    const Vec3 z = (last ? 1.0f : kRelaxation) * system.solve(sum);
    l.residual[first + index] = with_w(sum, 0.0f);
    l.correction[first + index] = with_w(z, 0.0f);
    if (last) l.relaxed[first + index] = with_w(z, 0.0f);
  }
};

/// Second half on a coarser level: adds the correction of the level below it and takes a Jacobi step.
struct Prolong {
  static constexpr const char* name = "prolong";
  static constexpr int kLanes = 32;
  StepView v;
  int first;
  template <class L>
  SIMPLEXSEG_HD void operator()(int index, L lanes) const {
    const LevelsView& l = v.levels;
    const int i = first + index;
    const CoarseRow* row = l.rows + (i - v.vertex_count);
    if (row[0].first_edge == row[1].first_edge) return;
    const float k = v.meshes[row->mesh].model;
    auto corrected = [&](int j) { return xyz(l.correction[j]) + xyz(l.relaxed[l.coarse_of[j]]); };
    Vec3 beside{0, 0, 0};
    for (int e = row[0].first_edge + lanes.lane; e < row[1].first_edge; e += L::width) beside = beside + l.edges[e].conductance * corrected(l.edges[e].to);
    beside = {lanes.sum(beside.x), lanes.sum(beside.y), lanes.sum(beside.z)};
    if (lanes.lane != 0) return;
    const Vec3 own = corrected(i);
    const VertexSystem system(l.stiffness_a[i], l.stiffness_b[i], k * row->degree);
    l.relaxed[i] = with_w(own + kRelaxation * system.solve(xyz(l.residual[i]) - (system.times(own) - k * beside)), 0.0f);
  }
};

/// The end of the cycle, on the mesh itself.
SIMPLEXSEG_HD Vec3 end_cycle(const StepView& v, const MeshConstants& m, int i, Int4 nb) {
  const LevelsView& l = v.levels;
  auto corrected = [&](int j) { return xyz(l.correction[j]) + xyz(l.relaxed[l.coarse_of[j]]); };
  const Vec3 own = corrected(i);
  const Vec3 beside = (1.0f / 3.0f) * (corrected(nb.x) + corrected(nb.y) + corrected(nb.z));
  const VertexSystem system(l.stiffness_a[i], l.stiffness_b[i], m.model);
  return own + kRelaxation * system.solve(xyz(l.residual[i]) - (system.times(own) - m.model * beside));
}

}  // namespace simplexseg
