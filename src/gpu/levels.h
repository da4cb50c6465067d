// SPDX-License-Identifier: Apache-2.0
// Coarser levels of all meshes (mesh/hierarchy.h) in the layout of the multigrid kernels, and the V-cycle on these
// levels.
#pragma once
#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "forces/step_view.h"
#include "gpu/kernels.h"
#include "gpu/launcher.h"
#include "gpu/multigrid.h"
#include "mesh/hierarchy.h"

namespace simplexseg {

struct LevelArrays {
  std::vector<CoarseRow> rows;
  std::vector<int> parts, coarse_of;
  std::vector<CoarseEdge> edges;
  std::vector<int> first;  ///< first vertex of each coarser level, then the end of the last level
  std::vector<int> roots;  ///< for each mesh, its vertex on its coarsest level
};

/// Builds the hierarchies of all meshes and arranges their vertices by level, within a level by mesh.
inline LevelArrays arrange_levels(std::span<const MeshConstants> meshes, std::span<const Int4> neighbours) {
  LevelArrays all;
  std::vector<Hierarchy> hierarchies;
  std::size_t depth = 0;
  for (const MeshConstants& m : meshes) {
    std::vector<std::array<int, 3>> own(m.vertex_count);
    for (int i = 0; i < m.vertex_count; ++i) {
      const Int4 nb = neighbours[m.first_vertex + i];
      own[i] = {nb.x - m.first_vertex, nb.y - m.first_vertex, nb.z - m.first_vertex};
    }
    hierarchies.push_back(make_hierarchy(own));
    depth = std::max(depth, hierarchies.back().levels.size());
    all.roots.push_back(m.first_vertex);
  }
  std::vector<int>& finer = all.roots;  // first vertex of each mesh on the next finer level; at the end its root
  int next = static_cast<int>(neighbours.size());
  all.coarse_of.assign(next, 0);
  all.first.assign(1, next);
  for (std::size_t l = 0; l < depth; ++l) {
    for (std::size_t k = 0; k < hierarchies.size(); ++k) {
      if (l >= hierarchies[k].levels.size()) continue;
      const Hierarchy::Level& level = hierarchies[k].levels[l];
      for (int i = 0; i < level.size(); ++i) {
        CoarseRow row{static_cast<int>(all.parts.size()), static_cast<int>(all.edges.size()), 0, static_cast<int>(k)};
        for (int p = level.part_first[i]; p < level.part_first[i + 1]; ++p) {
          all.parts.push_back(finer[k] + level.parts[p]);
          all.coarse_of[all.parts.back()] = next + i;
        }
        for (int e = level.edge_first[i]; e < level.edge_first[i + 1]; ++e) {
          all.edges.push_back({next + level.edges[e].to, level.edges[e].conductance});
          row.degree += level.edges[e].conductance;
        }
        all.rows.push_back(row);
      }
      finer[k] = next;
      next += level.size();
      all.coarse_of.resize(next, 0);
    }
    all.first.push_back(next);
  }
  all.rows.push_back({static_cast<int>(all.parts.size()), static_cast<int>(all.edges.size()), 0, 0});
  if (all.edges.empty()) all.edges.push_back({0, 0});
  return all;
}

template <class Executor>
class CoarseLevels {
  template <class T>
  using Array = typename Executor::template Array<T>;

 public:
  /// Builds the hierarchies, once per object. Slow for many vertices, so it is called when settings change, not during
  /// a run of steps.
  void arrange(std::span<const MeshConstants> meshes, std::span<const Int4> neighbours) {
    if (!arranged_.first.empty()) return;
    arranged_ = arrange_levels(meshes, neighbours);
    choose_small_levels();
  }
  void allocate(std::span<const MeshConstants> meshes, std::span<const Int4> neighbours) {
    if (allocated_) return;
    arrange(meshes, neighbours);
    rows_.assign_async(arranged_.rows), parts_.assign_async(arranged_.parts), edges_.assign_async(arranged_.edges),
        coarse_of_.assign_async(arranged_.coarse_of);
    for (Array<Vec4>* vector : vectors()) vector->resize(arranged_.first.back()), vector->fill_zero();
    allocated_ = true;
  }
  void release() {
    rows_.resize(0), parts_.resize(0), edges_.resize(0), coarse_of_.resize(0);
    for (Array<Vec4>* vector : vectors()) vector->resize(0);
    allocated_ = false;
  }
  bool allocated() const { return allocated_; }
  /// Vertex of the coarsest level of a mesh; -1 while the levels are not allocated.
  int root(std::size_t mesh) const { return allocated_ ? arranged_.roots[mesh] : -1; }

  LevelsView view() {
    return {rows_.data(),       parts_.data(),   edges_.data(),       coarse_of_.data(),  residual_.data(),
            correction_.data(), relaxed_.data(), stiffness_a_.data(), stiffness_b_.data()};
  }
  /// Calls add(name, arrays...) for each group of arrays.
  template <class Add>
  void list_arrays(Add&& add) const {
    add("levels", rows_, parts_, edges_, coarse_of_),
        add("level vectors", residual_, correction_, relaxed_, stiffness_a_, stiffness_b_);
  }

  /// Computes the stiffness E of all coarser levels from E of the mesh vertices.
  void sum_stiffness(Launcher<Executor>& launcher, const StepView& view) const {
    for (int l = 0; l < separate_levels(); ++l) launcher.run(CoarseStiffness{view, arranged_.first[l]}, size(l));
    if (small_.count > 1) launcher.run(SmallStiffness{view, small_});
  }
  /// Runs the part of the V-cycle on the coarser levels, after IntegrateKernel and before CorrectedStep.
  void cycle(Launcher<Executor>& launcher, const StepView& view) const {
    launcher.run(Restrict<true>{view, arranged_.first[0]}, size(0));
    for (int l = 1; l < separate_levels(); ++l) launcher.run(Restrict<false>{view, arranged_.first[l]}, size(l));
    if (small_.count > 1) launcher.run(SmallCycle{view, small_});
    for (int l = std::min(large_ - 1, depth() - 2); l >= 0; --l)
      launcher.run(Prolong{view, arranged_.first[l]}, size(l));
  }

 private:
  std::array<Array<Vec4>*, 5> vectors() { return {&residual_, &correction_, &relaxed_, &stiffness_a_, &stiffness_b_}; }
  int depth() const { return static_cast<int>(arranged_.first.size()) - 1; }
  int size(int l) const { return arranged_.first[l + 1] - arranged_.first[l]; }

  /// Number of levels whose restriction runs in a separate kernel: the large ones and the first small one.
  int separate_levels() const { return large_ + (small_.count > 0 ? 1 : 0); }

  /// Chooses the small levels, starting with the coarsest. The finest of the coarser levels is never small.
  void choose_small_levels() {
    large_ = depth(), small_ = {};
    while (large_ > 1 && size(large_ - 1) <= SmallLevels::kMaxLevelVertices &&
           depth() - large_ < SmallLevels::kMaxLevels) {
      const SmallLevels candidate = small_levels(large_ - 1);
      if (candidate.shared_bytes() > SmallLevels::kMaxBytes) return;
      --large_, small_ = candidate;
    }
  }
  /// Description of the levels from l to the coarsest as small levels.
  SmallLevels small_levels(int l) const {
    SmallLevels small;
    small.count = depth() - l;
    std::copy_n(arranged_.first.begin() + l, small.count + 1, small.first);
    const auto row = [&](int vertex) { return arranged_.rows[vertex - arranged_.first[0]]; };
    const CoarseRow first = row(small.first[0]), second = row(small.first[1]), end = row(small.first[small.count]);
    small.first_part = second.first_part, small.parts = end.first_part - second.first_part;
    small.first_edge = first.first_edge, small.edges = end.first_edge - first.first_edge;
    return small;
  }

  LevelArrays arranged_;  ///< empty until arrange()
  int large_ = 0;         ///< number of coarser levels that are not small
  SmallLevels small_;
  bool allocated_ = false;
  Array<CoarseRow> rows_;
  Array<CoarseEdge> edges_;
  Array<int> parts_, coarse_of_;
  Array<Vec4> residual_, correction_, relaxed_, stiffness_a_, stiffness_b_;
};

}  // namespace simplexseg
