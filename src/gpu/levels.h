// SPDX-License-Identifier: Apache-2.0
// The coarser levels of all meshes (mesh/hierarchy.h), as the multigrid kernels read them, and the cycle over them.
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
  std::vector<int> first;  ///< vertex of each coarser level, and the end of the last; counted over all levels
  std::vector<int> roots;  ///< of each mesh: the vertex that stands for all of it
};

/// Level by level, on each of them mesh by mesh.
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
  std::vector<int>& finer = all.roots;  // of each mesh: its first vertex on the level above, at last its root
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
  /// Takes a while with many vertices: when meshes are loaded that may need it, not in the middle of a run.
  void arrange(std::span<const MeshConstants> meshes, std::span<const Int4> neighbours) {
    if (!arranged_.first.empty()) return;
    arranged_ = arrange_levels(meshes, neighbours);
    tell_small_levels();
  }
  void hold(std::span<const MeshConstants> meshes, std::span<const Int4> neighbours) {
    if (held_) return;
    arrange(meshes, neighbours);
    rows_.assign_kept(arranged_.rows), parts_.assign_kept(arranged_.parts), edges_.assign_kept(arranged_.edges),
        coarse_of_.assign_kept(arranged_.coarse_of);
    for (Array<Vec4>* vector : vectors()) vector->resize(arranged_.first.back()), vector->fill_zero();
    held_ = true;
  }
  void drop() {
    rows_.resize(0), parts_.resize(0), edges_.resize(0), coarse_of_.resize(0);
    for (Array<Vec4>* vector : vectors()) vector->resize(0);
    held_ = false;
  }
  bool held() const { return held_; }
  /// The vertex that stands for all of a mesh; -1 while levels are not held.
  int root(std::size_t mesh) const { return held_ ? arranged_.roots[mesh] : -1; }

  LevelsView view() {
    return {rows_.data(),       parts_.data(),   edges_.data(),       coarse_of_.data(),  residual_.data(),
            correction_.data(), relaxed_.data(), stiffness_a_.data(), stiffness_b_.data()};
  }
  /// add(name, arrays...) for each group.
  template <class Add>
  void list(Add&& add) const {
    add("levels", rows_, parts_, edges_, coarse_of_),
        add("level vectors", residual_, correction_, relaxed_, stiffness_a_, stiffness_b_);
  }

  /// After the mesh's own: E of the coarser levels.
  void sum_stiffness(Launcher<Executor>& launcher, const StepView& view) const {
    for (int l = 0; l < summed(); ++l) launcher.run(CoarseStiffness{view, arranged_.first[l]}, size(l));
    if (small_.count > 1) launcher.run(SmallStiffness{view, small_});
  }
  /// After IntegrateKernel has begun it: the cycle down and up the levels. CorrectedStep ends it.
  void cycle(Launcher<Executor>& launcher, const StepView& view) const {
    launcher.run(Restrict<true>{view, arranged_.first[0]}, size(0));
    for (int l = 1; l < summed(); ++l) launcher.run(Restrict<false>{view, arranged_.first[l]}, size(l));
    if (small_.count > 1) launcher.run(SmallCycle{view, small_});
    for (int l = std::min(large_ - 1, depth() - 2); l >= 0; --l)
      launcher.run(Prolong{view, arranged_.first[l]}, size(l));
  }

 private:
  std::array<Array<Vec4>*, 5> vectors() { return {&residual_, &correction_, &relaxed_, &stiffness_a_, &stiffness_b_}; }
  int depth() const { return static_cast<int>(arranged_.first.size()) - 1; }
  int size(int l) const { return arranged_.first[l + 1] - arranged_.first[l]; }

  /// Levels that are summed each in a kernel of its own: the large ones and the first small one.
  int summed() const { return large_ + (small_.count > 0 ? 1 : 0); }

  /// From the coarsest level up; the one next to the mesh never is.
  void tell_small_levels() {
    large_ = depth(), small_ = {};
    while (large_ > 1 && size(large_ - 1) <= SmallLevels::kLargest && depth() - large_ < SmallLevels::kMost) {
      const SmallLevels more = small_levels(large_ - 1);
      if (more.shared_bytes() > SmallLevels::kMostBytes) return;
      --large_, small_ = more;
    }
  }
  /// Those from level l on.
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

  LevelArrays arranged_;  ///< empty until they may be needed
  int large_ = 0;         ///< levels that are not small
  SmallLevels small_;
  bool held_ = false;
  Array<CoarseRow> rows_;
  Array<CoarseEdge> edges_;
  Array<int> parts_, coarse_of_;
  Array<Vec4> residual_, correction_, relaxed_, stiffness_a_, stiffness_b_;
};

}  // namespace simplexseg
