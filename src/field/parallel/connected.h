// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "core/atomics.h"
#include "field/parallel/executor.h"

namespace simplexseg {

/// Union-find forest of connected voxels: the parent of a voxel of the set has a lower index, or is the voxel itself (a
/// root); it is -1 for other voxels. Trees are joined by an atomic minimum on the parent of the higher root; a thread
/// whose minimum replaces another parent joins that one too. Source: Playne and Hawick 2018, A New Algorithm for
/// Parallel Connected-Component Labelling on GPUs.
struct VoxelForest {
  int* parent;

  /// Root of a voxel of the set, with path compression (halving).
  SIMPLEXSEG_HD int root(int v) const {
    int ancestor = load_relaxed(parent + v);
    while (ancestor != v) {
      const int next = load_relaxed(parent + ancestor);
      if (next != ancestor) atomic_min(parent + v, next);
      v = ancestor;
      ancestor = next;
    }
    return v;
  }
  SIMPLEXSEG_HD void join(int a, int b) const {
    for (;;) {
      a = root(a);
      b = root(b);
      if (a == b) return;
      const int low = smaller(a, b), high = a < b ? b : a;
      const int replaced = atomic_min(parent + high, low);
      if (replaced == high) return;
      a = replaced;  // by another thread: it is connected to `low` too
      b = low;
    }
  }
};

/// Result of keep_connected().
struct KeptVoxels {
  const int* parent;
  const std::uint8_t* keep;
  SIMPLEXSEG_HD bool operator()(int v) const { return parent[v] >= 0 && keep[parent[v]] != 0; }
};

/// Cells with set(CellAt) in components (six neighbours) that contain a cell with start(CellAt). `parent`, `keep`:
/// workspace of a value for each cell. Three launches.
template <class Executor, class Set, class Start>
KeptVoxels keep_connected(const Executor& executor, const BoxGrid& grid, const Set& set, const Start& start,
                          int* parent, std::uint8_t* keep) {
  const int row = grid.row(), plane = grid.plane();
  const VoxelForest forest{parent};
  executor.each_cell(grid, [=] SIMPLEXSEG_KERNEL(const CellAt& at) {  // the first cell of a run in a row is its root
    const int v = at.v;
    int* const to = parent;  // nvcc forbids the first use of a captured variable in if constexpr
    const BoxGrid& cells = grid;
    keep[v] = 0;
    int first = -1;
    if (set(at)) {
      first = v;
      if constexpr (Executor::kCellsInOrder) {
        if (at.left != 0 && to[v - 1] >= 0) first = to[v - 1];
      } else {
        for (int i = at.i - 1; i >= 0 && set(cell_at(cells, i, at.j, at.k)); --i) --first;
      }
    }
    to[v] = first;
  });
  executor.each_cell(grid, [=] SIMPLEXSEG_KERNEL(const CellAt& at) {
    const int v = at.v;
    const auto in_set = [=](int u) { return load_relaxed(parent + u) >= 0; };
    if (!in_set(v)) return;
    const bool begins = at.left == 0 || !in_set(v - 1);
    // Joins neighbouring runs once, at their first common cell.
    if (at.j > 0 && in_set(v - row) && (begins || !in_set(v - row - 1))) forest.join(v, v - row);
    if (at.k > 0 && in_set(v - plane) && (begins || !in_set(v - plane - 1))) forest.join(v, v - plane);
  });
  executor.each_cell(grid, [=] SIMPLEXSEG_KERNEL(const CellAt& at) {
    const int v = at.v;
    if (load_relaxed(parent + v) < 0) return;
    int root = -1;
    if constexpr (Executor::kCellsInOrder)
      if (at.left != 0) root = load_relaxed(parent + v - 1);
    if (root < 0) root = forest.root(v);
    store_relaxed(parent + v, root);
    if (start(at)) store_relaxed(keep + root, 1);
  });
  return {parent, keep};
}

}  // namespace simplexseg
