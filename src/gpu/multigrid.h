// SPDX-License-Identifier: Apache-2.0
// The multigrid correction: one V-cycle on a linear model of the forces turns the force f of each vertex into a step z
// that moves slow modes as far as fast ones (docs/mathematics.md, section 3). The model is  A = k L + E: L the graph
// Laplacian of the mesh, k half the bound of the internal forces, E what image and attraction support a vertex with. It
// changes how fast the fixed point is reached, never where it lies.
#pragma once
#include "forces/force_list.h"
#include "forces/lanes.h"
#include "forces/step_view.h"

namespace simplexseg {

/// The linear system of one vertex of one level, 3 x 3: (degree k) I + E.
struct VertexSystem {
  float xx, xy, xz, yy, yz, zz;
  SIMPLEXSEG_HD VertexSystem(Vec4 a, Vec4 b, float diagonal)
      : xx(a.x + diagonal), xy(a.y), xz(a.z), yy(a.w + diagonal), yz(b.x), zz(b.y + diagonal) {}
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
    float along = 0, all = m.support * m.model, image = 1;
    each_force([&]<class F>(F) {
      if constexpr ((kMask & bit(F::id)) != 0 && Pulls<F>) F::add_stiffness(v, m, i, all, image);
    });
    each_force([&]<class F>(F) {
      if constexpr ((kMask & bit(F::id)) != 0 && Displaces<F>) {
        if constexpr (F::kind == ForceKind::Image) along += m.forces.weight(F::id) * trust_of<F>(v, i);
        if constexpr (F::kind == ForceKind::External) all += m.forces.weight(F::id) * trust_of<F>(v, i);
      }
    });
    along *= image;
    const Vec3 n = xyz(v.frame[i]), an = along * n;
    v.levels.stiffness_a[i] = {an.x * n.x + all, an.x * n.y, an.x * n.z, an.y * n.y + all};
    v.levels.stiffness_b[i] = {an.y * n.z, an.z * n.z + all, 0, 0};
  }
};

// Of the levels below, `l` says where they are: in v.levels, or in the memory of a team.

/// E of vertex `at` (counted over all levels) of a coarser level: the sum over what it stands for.
template <class L>
SIMPLEXSEG_HD void sum_stiffness(const StepView& v, const LevelsView& l, int at, L lanes) {
  const CoarseRow* row = l.rows + (at - v.vertex_count);
  Vec4 a{0, 0, 0, 0}, b{0, 0, 0, 0};
  for (int p = row[0].first_part + lanes.lane; p < row[1].first_part; p += L::width) {
    const Vec4 x = l.stiffness_a[l.parts[p]], y = l.stiffness_b[l.parts[p]];
    a = {a.x + x.x, a.y + x.y, a.z + x.z, a.w + x.w}, b = {b.x + y.x, b.y + y.y, 0, 0};
  }
  a = {lanes.sum(a.x), lanes.sum(a.y), lanes.sum(a.z), lanes.sum(a.w)}, b = {lanes.sum(b.x), lanes.sum(b.y), 0, 0};
  if (lanes.lane == 0) l.stiffness_a[at] = a, l.stiffness_b[at] = b;
}

/// First half of the cycle on the mesh: a Jacobi step from 0.
SIMPLEXSEG_HD void begin_cycle(const StepView& v, const MeshConstants& m, int i, Vec3 force) {
  const LevelsView& l = v.levels;
  l.residual[i] = with_w(force, 0.0f);
  l.correction[i] = with_w(kRelaxation * VertexSystem(l.stiffness_a[i], l.stiffness_b[i], m.model).solve(force), 0.0f);
}

/// Sums what is left of the residual onto vertex `at` of the next coarser level, and takes the Jacobi step there.
template <bool kFromMesh, class L>
SIMPLEXSEG_HD void restrict_to(const StepView& v, const LevelsView& l, int at, L lanes) {
  const CoarseRow* row = l.rows + (at - v.vertex_count);
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
      for (int e = fine[0].first_edge; e < fine[1].first_edge; ++e)
        beside = beside + l.edges[e].conductance * xyz(l.correction[l.edges[e].to]);
    }
    const VertexSystem system(l.stiffness_a[i], l.stiffness_b[i], k * degree);
    sum = sum + (xyz(l.residual[i]) - (system.times(xyz(l.correction[i])) - k * beside));
  }
  sum = {lanes.sum(sum.x), lanes.sum(sum.y), lanes.sum(sum.z)};
  if (lanes.lane != 0) return;
  const bool last = row[0].first_edge == row[1].first_edge;  // a whole mesh, or part of one: solved exactly
  const VertexSystem system(l.stiffness_a[at], l.stiffness_b[at], k * row->degree);
  const Vec3 z = (last ? 1.0f : kRelaxation) * system.solve(sum);
  l.residual[at] = with_w(sum, 0.0f);
  l.correction[at] = with_w(z, 0.0f);
  if (last) l.relaxed[at] = with_w(z, 0.0f);
}

/// Second half at vertex `at` of a coarser level: adds the correction of the level below it and takes a Jacobi step.
template <class L>
SIMPLEXSEG_HD void prolong_to(const StepView& v, const LevelsView& l, int at, L lanes) {
  const CoarseRow* row = l.rows + (at - v.vertex_count);
  if (row[0].first_edge == row[1].first_edge) return;
  const float k = v.meshes[row->mesh].model;
  auto corrected = [&](int j) { return xyz(l.correction[j]) + xyz(l.relaxed[l.coarse_of[j]]); };
  Vec3 beside{0, 0, 0};
  for (int e = row[0].first_edge + lanes.lane; e < row[1].first_edge; e += L::width)
    beside = beside + l.edges[e].conductance * corrected(l.edges[e].to);
  beside = {lanes.sum(beside.x), lanes.sum(beside.y), lanes.sum(beside.z)};
  if (lanes.lane != 0) return;
  const Vec3 own = corrected(at);
  const VertexSystem system(l.stiffness_a[at], l.stiffness_b[at], k * row->degree);
  l.relaxed[at] =
      with_w(own + kRelaxation * system.solve(xyz(l.residual[at]) - (system.times(own) - k * beside)), 0.0f);
}

// One large level a kernel. All wait for memory: what a vertex needs is shared out among lanes.
struct CoarseStiffness {
  static constexpr const char* name = "coarse stiffness";
  static constexpr int kLanes = 8, scratch = 0;
  StepView v;
  int first;  ///< vertex of the level, counted over all levels
  template <class L>
  SIMPLEXSEG_HD void operator()(int index, L lanes) const {
    sum_stiffness(v, v.levels, first + index, lanes);
  }
};
template <bool kFromMesh>
struct Restrict {
  static constexpr const char* name = "restrict";
  static constexpr int kLanes = kFromMesh ? 4 : 8, scratch = 0;
  StepView v;
  int first;
  template <class L>
  SIMPLEXSEG_HD void operator()(int index, L lanes) const {
    restrict_to<kFromMesh>(v, v.levels, first + index, lanes);
  }
};
struct Prolong {
  static constexpr const char* name = "prolong";
  static constexpr int kLanes = 8, scratch = 0;
  StepView v;
  int first;
  template <class L>
  SIMPLEXSEG_HD void operator()(int index, L lanes) const {
    prolong_to(v, v.levels, first + index, lanes);
  }
};

/// The small levels, one after the other in one kernel: by themselves they would be little but launches. What comes
/// down to the first of them was summed before. A team that has memory of its own works there, where nothing is far.
struct SmallLevels {
  static constexpr int kMost = 12, kLargest = 256, kVectors = 5;
  static constexpr std::size_t kMostBytes = 96 * 1024;
  int count = 0;
  int first[kMost + 1] = {};      ///< as LevelArrays::first, from the first small level on
  int first_part = 0, parts = 0;  ///< of all but the first small level
  int first_edge = 0, edges = 0;  ///< of all of them

  SIMPLEXSEG_HD int vertices() const { return first[count] - first[0]; }
  std::size_t shared_bytes() const {
    const std::size_t n = static_cast<std::size_t>(vertices());
    return n * (kVectors * sizeof(Vec4) + sizeof(CoarseRow) + sizeof(int)) + sizeof(CoarseRow) +
           static_cast<std::size_t>(edges) * sizeof(CoarseEdge) + static_cast<std::size_t>(parts) * sizeof(int);
  }
  template <class Team, class Work>
  SIMPLEXSEG_HD void each(int level, const Team& team, Work work) const {
    for (int at = first[level] + team.group; at < first[level + 1]; at += Team::groups) work(at);
    team.sync();
  }
  /// Where the team works: the levels as they are, or copies, in which vertices, parts and edges are counted as there.
  template <class Team>
  SIMPLEXSEG_HD LevelsView bring(const StepView& v, const Team& team) const {
    if constexpr (!Team::kOwnMemory) {
      return v.levels;
    } else {
      const LevelsView& from = v.levels;
      LevelsView own;
      auto* memory = static_cast<unsigned char*>(team.memory);
      auto take = [&]<class T>(T*& place, const std::remove_const_t<T>* all, int begin, int n) {
        auto* to = reinterpret_cast<std::remove_const_t<T>*>(memory);
        memory += static_cast<std::size_t>(n) * sizeof(T);
        for (int k = team.thread; k < n; k += Team::threads) team.copy(to + k, all + begin + k);
        place = to - begin;
      };
      // What no cycle changes, then what the kernels before this one have left.
      const int n = vertices();
      take(own.rows, from.rows, first[0] - v.vertex_count, n + 1);
      auto* const vectors = memory;
      memory += static_cast<std::size_t>(kVectors * n) * sizeof(Vec4);
      take(own.edges, from.edges, first_edge, edges);
      take(own.parts, from.parts, first_part, parts), take(own.coarse_of, from.coarse_of, first[0], n);
      team.wait_for_earlier_kernels();
      memory = vectors;
      take(own.residual, from.residual, first[0], n), take(own.correction, from.correction, first[0], n);
      take(own.relaxed, from.relaxed, first[0], n);
      take(own.stiffness_a, from.stiffness_a, first[0], n), take(own.stiffness_b, from.stiffness_b, first[0], n);
      team.wait_for_copies();
      return own;
    }
  }
  /// What the team has at vertices begin ... end - 1 to where others read it.
  template <class Team>
  SIMPLEXSEG_HD void hand_on(const Team& team, const Vec4* own, Vec4* all, int begin, int end) const {
    if constexpr (Team::kOwnMemory)
      for (int at = begin + team.thread; at < end; at += Team::threads) all[at] = own[at];
  }
};
struct SmallStiffness {
  static constexpr const char* name = "small levels' stiffness";
  static constexpr int kTeam = 1024;
  StepView v;
  SmallLevels levels;
  template <class Team>
  SIMPLEXSEG_HD void operator()(Team team) const {
    const LevelsView own = levels.bring(v, team);
    for (int l = 1; l < levels.count; ++l) levels.each(l, team, [&](int at) { sum_stiffness(v, own, at, team.lanes); });
    levels.hand_on(team, own.stiffness_a, v.levels.stiffness_a, levels.first[1], levels.first[levels.count]);
    levels.hand_on(team, own.stiffness_b, v.levels.stiffness_b, levels.first[1], levels.first[levels.count]);
  }
};
struct SmallCycle {
  static constexpr const char* name = "small levels";
  static constexpr int kTeam = 1024;
  StepView v;
  SmallLevels levels;
  template <class Team>
  SIMPLEXSEG_HD void operator()(Team team) const {
    const LevelsView own = levels.bring(v, team);
    for (int l = 1; l < levels.count; ++l)
      levels.each(l, team, [&](int at) { restrict_to<false>(v, own, at, team.lanes); });
    for (int l = levels.count - 2; l >= 0; --l)
      levels.each(l, team, [&](int at) { prolong_to(v, own, at, team.lanes); });
    levels.hand_on(team, own.relaxed, v.levels.relaxed, levels.first[0], levels.first[1]);
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
