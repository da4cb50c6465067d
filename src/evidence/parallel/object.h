// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>

#include "core/atomics.h"
#include "evidence/marked_voxels.h"
#include "evidence/parallel/executor.h"
#include "image/distance_map.h"

namespace simplexseg {

/// Sets of connected voxels as trees of voxels, each pointing to one that comes before it. Sources: Komura 2015,
/// GPU-based cluster-labeling algorithm without the use of conventional iteration; Jaiganesh and Burtscher 2018, A
/// High-Performance Connected Components Implementation for GPUs (shorter ways while they are gone).
struct Trees {
  int* parent;

  SIMPLEXSEG_HD int root(int v) const {
    int up = load_relaxed(&parent[v]);
    while (up != v) {
      const int next = load_relaxed(&parent[up]);
      if (next == up) return up;
      parent[v] = next;  // what another thread joins v to meanwhile, that thread joins with v's old parent
      v = next;
      up = load_relaxed(&parent[v]);
    }
    return v;
  }
  SIMPLEXSEG_HD void join(int a, int b) const {
    while (true) {
      a = root(a), b = root(b);
      if (a == b) return;
      const int high = a > b ? a : b, low = a > b ? b : a;
      const int before = atomic_min(&parent[high], low);
      if (before == high) return;  // else another one was faster: what it joined is joined with this
      a = before, b = low;
    }
  }
};

/// What all kernels of ParallelObject see.
struct ObjectView {
  static constexpr int kRun = 32;  ///< voxels side by side in a row that point to the first of them from the start
  int size[3];
  const float* field;
  const Known* known;
  std::uint8_t* voxels;  ///< of the object
  std::uint8_t* kept;    ///< of roots: whether something starts there
  Trees trees;

  SIMPLEXSEG_HD bool at_side(int v) const {
    const int i = v % size[0], j = v / size[0] % size[1], k = v / (size[0] * size[1]);
    return i == 0 || j == 0 || k == 0 || i == size[0] - 1 || j == size[1] - 1 || k == size[2] - 1;
  }
  /// The first voxel of the run that a voxel of the set is in.
  template <class InSet>
  SIMPLEXSEG_HD int first_of_run(int v, const InSet& in_set) const {
    int first = v;
    for (int i = v % size[0] % kRun; i > 0 && in_set(first - 1); --i) --first;
    return first;
  }
};

struct BeginObject {
  ObjectView view;
  SIMPLEXSEG_HD void operator()(int v) const {
    const float* const field = view.field;
    const auto in_set = [=](int u) { return field[u] > 0.5f; };
    view.voxels[v] = in_set(v) ? 1 : 0;
    view.kept[v] = 0;
    if (in_set(v)) view.trees.parent[v] = view.first_of_run(v, in_set);
  }
};

/// Joins runs with those before them that they touch: at the first voxel where they do.
struct JoinRuns {
  ObjectView view;
  int set;
  SIMPLEXSEG_HD void operator()(int v) const {
    const std::uint8_t* const voxels = view.voxels;
    if (voxels[v] != set) return;
    const int row = view.size[0], plane = row * view.size[1], in_run = v % row % ObjectView::kRun;
    const bool goes_on = in_run > 0 && voxels[v - 1] == set;
    if (v % row > 0 && in_run == 0 && voxels[v - 1] == set) view.trees.join(v, v - 1);
    if (v / row % view.size[1] > 0 && voxels[v - row] == set && !(goes_on && voxels[v - 1 - row] == set))
      view.trees.join(v, v - row);
    if (v >= plane && voxels[v - plane] == set && !(goes_on && voxels[v - 1 - plane] == set))
      view.trees.join(v, v - plane);
  }
};

/// Lets every voxel point to its root, and roots know whether something starts in their set.
struct KeepStarts {
  ObjectView view;
  int set;  ///< 1: the object, which starts at inside marks; 0: the rest, at the sides and at outside marks
  SIMPLEXSEG_HD void operator()(int v) const {
    if (view.voxels[v] != set) return;
    const int root = view.trees.root(v);
    view.trees.parent[v] = root;
    const bool starts = set ? view.known[v] == Known::Inside : view.known[v] == Known::Outside || view.at_side(v);
    if (starts && view.kept[root] == 0) store_relaxed(&view.kept[root], 1);
  }
};

/// The object without what no mark is in.
struct DropUnmarked {
  ObjectView view;
  SIMPLEXSEG_HD void operator()(int v) const {
    if (view.voxels[v] && !view.kept[view.trees.parent[v]]) view.voxels[v] = 0;
  }
};
struct BeginRest {
  ObjectView view;
  SIMPLEXSEG_HD void operator()(int v) const {
    const std::uint8_t* const voxels = view.voxels;
    const auto in_set = [=](int u) { return voxels[u] == 0; };
    view.kept[v] = 0;
    if (in_set(v)) view.trees.parent[v] = view.first_of_run(v, in_set);
  }
};
struct FillHoles {
  ObjectView view;
  SIMPLEXSEG_HD void operator()(int v) const {
    if (!view.voxels[v] && !view.kept[view.trees.parent[v]]) view.voxels[v] = 1;
  }
};

/// Of the object: the least and the largest index along each axis, and how many voxels are near a side of the box.
struct ObjectExtent {
  int low[3], high[3];
  double near;
};
struct MeasureExtent {
  ObjectView view;
  ObjectExtent* extent;
  SIMPLEXSEG_HD void operator()(int v) const {
    if (!view.voxels[v]) return;
    const int at[3]{v % view.size[0], v / view.size[0] % view.size[1], v / (view.size[0] * view.size[1])};
    for (int a = 0; a < 3; ++a) {
      if (at[a] < load_relaxed(&extent->low[a])) atomic_min(&extent->low[a], at[a]);
      if (at[a] > load_relaxed(&extent->high[a])) atomic_max(&extent->high[a], at[a]);
    }
  }
};
struct NearSide {
  static constexpr int kVoxels = 4;
  ObjectView view;
  SIMPLEXSEG_HD float operator()(int v) const {
    if (!view.voxels[v]) return 0;
    const int at[3]{v % view.size[0], v / view.size[0] % view.size[1], v / (view.size[0] * view.size[1])};
    bool near = false;
    for (int a = 0; a < 3; ++a) near = near || at[a] <= kVoxels || view.size[a] - 1 - at[a] <= kVoxels;
    return near ? 1.0f : 0.0f;
  }
};

/// object_of_field() on an executor: the same voxels.
template <class Executor>
class ParallelObject {
 public:
  ParallelObject(const Executor& executor, const VoxelBox& box)
      : executor_(executor),
        box_(box),
        parent_(executor.template array<int>(box.voxel_count())),
        kept_(executor.template array<std::uint8_t>(box.voxel_count())),
        extent_(executor.template array<ObjectExtent>(1)) {}

  struct Summary {
    VoxelBox around{};
    double border_share = 0;
  };
  Summary find(const float* field, const Known* known, std::uint8_t* voxels) {
    const int n = static_cast<int>(box_.voxel_count());
    const ObjectView view{
        {box_.size[0], box_.size[1], box_.size[2]}, field, known, voxels, kept_.data(), {parent_.data()}};
    executor_.each(n, BeginObject{view});
    executor_.each(n, JoinRuns{view, 1});
    executor_.each(n, KeepStarts{view, 1});
    executor_.each(n, DropUnmarked{view});
    executor_.each(n, BeginRest{view});
    executor_.each(n, JoinRuns{view, 0});
    executor_.each(n, KeepStarts{view, 0});
    executor_.each(n, FillHoles{view});
    const ObjectExtent none{{box_.size[0], box_.size[1], box_.size[2]}, {-1, -1, -1}, 0};
    executor_.upload(std::span<const ObjectExtent>(&none, 1), extent_.data());
    executor_.each(n, MeasureExtent{view, extent_.data()});
    executor_.sum_into(n, NearSide{view}, &extent_.data()->near);
    const ObjectExtent extent = value_at(executor_, extent_.data());
    Summary found;
    double far = 1;
    for (int a = 0; a < 3; ++a) {
      far *= std::max(0, box_.size[a] - 2 * (NearSide::kVoxels + 1));
      if (extent.high[0] < 0) continue;
      found.around.first[a] = box_.first[a] + extent.low[a];
      found.around.size[a] = extent.high[a] - extent.low[a] + 1;
    }
    if (n > far) found.border_share = extent.near / (n - far);
    return found;
  }
  std::size_t bytes() const { return parent_.bytes() + kept_.bytes() + extent_.bytes(); }

 private:
  const Executor& executor_;
  VoxelBox box_;
  typename Executor::template Array<int> parent_;
  typename Executor::template Array<std::uint8_t> kept_;
  typename Executor::template Array<ObjectExtent> extent_;
};

}  // namespace simplexseg
