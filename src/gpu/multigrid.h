// SPDX-License-Identifier: Apache-2.0
// Multigrid correction: one V-cycle on a linear model of the forces computes from the force f of each vertex an update
// z that reduces the error of slow modes as much as that of fast ones (docs/mathematics.md, section 3). The model is A
// = k L + E: L is the graph Laplacian of the mesh, divided by the number of neighbours; k is half the bound of the
// internal forces, or a tenth of the bound of the others if that is larger; E is the stiffness of image forces and
// attraction at each vertex. The correction accelerates the convergence and does not change the fixed point.
#pragma once
#include "forces/force_list.h"
#include "forces/lanes.h"
#include "forces/step_view.h"
#include "gpu/forces_in_use.h"

namespace simplexseg {

/// Linear 3 x 3 system of one vertex of one level: (degree k) I + E. `a`, `b`: E as in LevelsView; `diagonal`: degree
/// k.
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
/// Relaxation factor of the Jacobi smoother.
inline constexpr float kRelaxation = 0.7f;

/// Computes E of each vertex of the mesh: the sum of k_f c n n^T for image forces with weight k_f and confidence c,
/// reduced where points attract; k_f w I for attraction, w: sum of the patch weights, at most 1; the regularisation.
template <unsigned kMask>
struct LocalStiffness {
  static constexpr const char* name = "stiffness";
  StepView v;
  SIMPLEXSEG_HD void operator()(int i) const {
    const MeshConstants& m = v.meshes[v.neighbours[i].w];
    float normal = 0, isotropic = m.regularisation * m.model, image = 1;
    each_force([&]<class F>(F) {
      if constexpr ((kMask & bit(F::id)) != 0 && Pulls<F>) {
        if (in_use<F>(v)) F::add_stiffness(v, m, i, isotropic, image);
      }
    });
    each_force([&]<class F>(F) {
      if constexpr ((kMask & bit(F::id)) != 0 && Displaces<F>) {
        if (!in_use<F>(v)) return;
        if constexpr (F::kind == ForceKind::Image) normal += m.forces.weight(F::id) * confidence_of<F>(v, i);
        if constexpr (F::kind == ForceKind::External) isotropic += m.forces.weight(F::id) * confidence_of<F>(v, i);
      }
    });
    normal *= image;
    const Vec3 n = xyz(v.frame[i]), an = normal * n;
    v.levels.stiffness_a[i] = {an.x * n.x + isotropic, an.x * n.y, an.x * n.z, an.y * n.y + isotropic};
    v.levels.stiffness_b[i] = {an.y * n.z, an.z * n.z + isotropic, 0, 0};
  }
};

// In the following functions `l` is v.levels, or a copy of small levels in the shared memory of a block.

/// Computes E of vertex `at` of a coarser level as the sum over its parts on the finer level. `at`: index over all
/// levels.
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

/// First half of the V-cycle on the mesh: a damped Jacobi step from the initial guess 0. `force`: right-hand side.
SIMPLEXSEG_HD void begin_cycle(const StepView& v, const MeshConstants& m, int i, Vec3 force) {
  const LevelsView& l = v.levels;
  l.residual[i] = with_w(force, 0.0f);
  l.correction[i] = with_w(kRelaxation * VertexSystem(l.stiffness_a[i], l.stiffness_b[i], m.model).solve(force), 0.0f);
}

/// Restriction: computes the right-hand side of vertex `at` as the sum of the remaining residual over its parts on the
/// next finer level (kFromMesh: the mesh), then performs a damped Jacobi step.
template <bool kFromMesh, class L>
SIMPLEXSEG_HD void restrict_to(const StepView& v, const LevelsView& l, int at, L lanes) {
  const CoarseRow* row = l.rows + (at - v.vertex_count);
  const float k = v.meshes[row->mesh].model;
  Vec3 sum{0, 0, 0};
  for (int p = row[0].first_part + lanes.lane; p < row[1].first_part; p += L::width) {
    const int i = l.parts[p];
    float degree = 1;
    Vec3 neighbour_sum{0, 0, 0};
    if constexpr (kFromMesh) {
      const Int4 nb = v.neighbours[i];
      neighbour_sum = (1.0f / 3.0f) * (xyz(l.correction[nb.x]) + xyz(l.correction[nb.y]) + xyz(l.correction[nb.z]));
    } else {
      const CoarseRow* fine = l.rows + (i - v.vertex_count);
      degree = fine->degree;
      SIMPLEXSEG_UNROLL
      for (int e = fine[0].first_edge; e < fine[1].first_edge; ++e)
        neighbour_sum = neighbour_sum + l.edges[e].conductance * xyz(l.correction[l.edges[e].to]);
    }
    const VertexSystem system(l.stiffness_a[i], l.stiffness_b[i], k * degree);
    sum = sum + (xyz(l.residual[i]) - (system.times(xyz(l.correction[i])) - k * neighbour_sum));
  }
  sum = {lanes.sum(sum.x), lanes.sum(sum.y), lanes.sum(sum.z)};
  if (lanes.lane != 0) return;
  const bool last = row[0].first_edge == row[1].first_edge;  // coarsest level: solved exactly
  const VertexSystem system(l.stiffness_a[at], l.stiffness_b[at], k * row->degree);
  const Vec3 z = (last ? 1.0f : kRelaxation) * system.solve(sum);
  l.residual[at] = with_w(sum, 0.0f);
  l.correction[at] = with_w(z, 0.0f);
  if (last) l.relaxed[at] = with_w(z, 0.0f);
}

/// Prolongation: adds the correction of the next coarser level at vertex `at`, then performs a damped Jacobi step.
template <class L>
SIMPLEXSEG_HD void prolong_to(const StepView& v, const LevelsView& l, int at, L lanes) {
  const CoarseRow* row = l.rows + (at - v.vertex_count);
  if (row[0].first_edge == row[1].first_edge) return;
  const float k = v.meshes[row->mesh].model;
  auto corrected = [&](int j) { return xyz(l.correction[j]) + xyz(l.relaxed[l.coarse_of[j]]); };
  Vec3 neighbour_sum{0, 0, 0};
  for (int e = row[0].first_edge + lanes.lane; e < row[1].first_edge; e += L::width)
    neighbour_sum = neighbour_sum + l.edges[e].conductance * corrected(l.edges[e].to);
  neighbour_sum = {lanes.sum(neighbour_sum.x), lanes.sum(neighbour_sum.y), lanes.sum(neighbour_sum.z)};
  if (lanes.lane != 0) return;
  const Vec3 own = corrected(at);
  const VertexSystem system(l.stiffness_a[at], l.stiffness_b[at], k * row->degree);
  l.relaxed[at] =
      with_w(own + kRelaxation * system.solve(xyz(l.residual[at]) - (system.times(own) - k * neighbour_sum)), 0.0f);
}

// Kernels that process one large level per launch. Memory latency limits them, so several lanes share one vertex.
struct CoarseStiffness {
  static constexpr const char* name = "coarse stiffness";
  static constexpr int kLanes = 8, scratch = 0;
  StepView v;
  int first;  ///< first vertex of the level, counted over all levels
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

/// Small levels, which one kernel processes in sequence: with one kernel per level, launches would dominate the time.
/// The restriction to the first small level precedes this kernel. A block with shared memory works on a copy of the
/// levels.
struct SmallLevels {
  static constexpr int kMaxLevels = 12, kMaxLevelVertices = 256, kVectors = 5;
  static constexpr std::size_t kMaxBytes = 96 * 1024;
  int count = 0;
  int first[kMaxLevels + 1] = {};  ///< part of LevelArrays::first that begins at the first small level
  int first_part = 0, parts = 0;   ///< range of the parts of all small levels except the first
  int first_edge = 0, edges = 0;   ///< range of the edges of all small levels

  SIMPLEXSEG_HD int vertices() const { return first[count] - first[0]; }
  std::size_t shared_bytes() const {
    const std::size_t n = static_cast<std::size_t>(vertices());
    return n * (kVectors * sizeof(Vec4) + sizeof(CoarseRow) + sizeof(int)) + sizeof(CoarseRow) +
           static_cast<std::size_t>(edges) * sizeof(CoarseEdge) + static_cast<std::size_t>(parts) * sizeof(int);
  }
  /// Calls work(at) for each vertex of a level.
  template <class Block, class Work>
  SIMPLEXSEG_HD void each(int level, const Block& block, Work work) const {
    for (int at = first[level] + block.group; at < first[level + 1]; at += Block::groups) work(at);
    block.sync();
  }
  /// Levels on which the block works: v.levels, or a copy in shared memory with the same indices.
  template <class Block>
  SIMPLEXSEG_HD LevelsView load_levels(const StepView& v, const Block& block) const {
    if constexpr (!Block::kUsesSharedMemory) {
      return v.levels;
    } else {
      const LevelsView& from = v.levels;
      LevelsView own;
      auto* memory = static_cast<unsigned char*>(block.memory);
      auto load = [&]<class T>(T*& array, const std::remove_const_t<T>* all, int begin, int n) {
        auto* to = reinterpret_cast<std::remove_const_t<T>*>(memory);
        memory += static_cast<std::size_t>(n) * sizeof(T);
        for (int k = block.thread; k < n; k += Block::threads) block.copy(to + k, all + begin + k);
        array = to - begin;
      };
      // Loads the constant arrays first, then waits for the earlier kernels and loads the arrays that they write.
      const int n = vertices();
      load(own.rows, from.rows, first[0] - v.vertex_count, n + 1);
      auto* const vectors = memory;
      memory += static_cast<std::size_t>(kVectors * n) * sizeof(Vec4);
      load(own.edges, from.edges, first_edge, edges);
      load(own.parts, from.parts, first_part, parts), load(own.coarse_of, from.coarse_of, first[0], n);
      block.wait_for_earlier_kernels();
      memory = vectors;
      load(own.residual, from.residual, first[0], n), load(own.correction, from.correction, first[0], n);
      load(own.relaxed, from.relaxed, first[0], n);
      load(own.stiffness_a, from.stiffness_a, first[0], n), load(own.stiffness_b, from.stiffness_b, first[0], n);
      block.wait_for_copies();
      return own;
    }
  }
  /// Copies the values of vertices begin ... end - 1 from `own`, in shared memory, to `all`; no copy without shared
  /// memory.
  template <class Block>
  SIMPLEXSEG_HD void write_back(const Block& block, const Vec4* own, Vec4* all, int begin, int end) const {
    if constexpr (Block::kUsesSharedMemory)
      for (int at = begin + block.thread; at < end; at += Block::threads) all[at] = own[at];
  }
};
struct SmallStiffness {
  static constexpr const char* name = "small levels' stiffness";
  static constexpr int kBlockThreads = 1024;
  StepView v;
  SmallLevels levels;
  template <class Block>
  SIMPLEXSEG_HD void operator()(Block block) const {
    const LevelsView own = levels.load_levels(v, block);
    for (int l = 1; l < levels.count; ++l)
      levels.each(l, block, [&](int at) { sum_stiffness(v, own, at, block.lanes); });
    levels.write_back(block, own.stiffness_a, v.levels.stiffness_a, levels.first[1], levels.first[levels.count]);
    levels.write_back(block, own.stiffness_b, v.levels.stiffness_b, levels.first[1], levels.first[levels.count]);
  }
};
struct SmallCycle {
  static constexpr const char* name = "small levels";
  static constexpr int kBlockThreads = 1024;
  StepView v;
  SmallLevels levels;
  template <class Block>
  SIMPLEXSEG_HD void operator()(Block block) const {
    const LevelsView own = levels.load_levels(v, block);
    for (int l = 1; l < levels.count; ++l)
      levels.each(l, block, [&](int at) { restrict_to<false>(v, own, at, block.lanes); });
    for (int l = levels.count - 2; l >= 0; --l)
      levels.each(l, block, [&](int at) { prolong_to(v, own, at, block.lanes); });
    levels.write_back(block, own.relaxed, v.levels.relaxed, levels.first[0], levels.first[1]);
  }
};

/// Second half of the V-cycle on the mesh: prolongation and a damped Jacobi step. Returns the update z of vertex i, mm.
SIMPLEXSEG_HD Vec3 end_cycle(const StepView& v, const MeshConstants& m, int i, Int4 nb) {
  const LevelsView& l = v.levels;
  auto corrected = [&](int j) { return xyz(l.correction[j]) + xyz(l.relaxed[l.coarse_of[j]]); };
  const Vec3 own = corrected(i);
  const Vec3 neighbour_sum = (1.0f / 3.0f) * (corrected(nb.x) + corrected(nb.y) + corrected(nb.z));
  const VertexSystem system(l.stiffness_a[i], l.stiffness_b[i], m.model);
  return own + kRelaxation * system.solve(xyz(l.residual[i]) - (system.times(own) - m.model * neighbour_sum));
}

}  // namespace simplexseg
