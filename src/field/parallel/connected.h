// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "core/atomics.h"
#include "field/parallel/executor.h"

namespace simplexseg {

/// Voxels that are connected, as a forest: each voxel of the set has a parent of a lower index, or is a root, its own
/// parent; -1 for the others. Trees of what is connected are joined by lowering the parent of the higher root. Threads
/// that do so at the same time may only overwrite a parent by another ancestor, or go on to join what they replaced.
/// Source: Playne and Hawick 2018, A New Algorithm for Parallel Connected-Component Labelling on GPUs.
struct VoxelForest {
  int* parent;

  /// Of a voxel of the set. Shortens the way for others.
  SIMPLEXSEG_HD int root(int v) const {
    int up = load_relaxed(parent + v);
    while (up != v) {
      const int next = load_relaxed(parent + up);
      if (next != up) atomic_min(parent + v, next);
      v = up;
      up = next;
    }
    return v;
  }
  SIMPLEXSEG_HD void join(int a, int b) const {
    for (;;) {
      a = root(a);
      b = root(b);
      if (a == b) return;
      const int low = smaller(a, b), high = a < b ? b : a;
      const int was = atomic_min(parent + high, low);
      if (was == high) return;
      a = was;  // another thread joined it to something: that is connected to `low`, too
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

/// Finds the cells with set(CellAt) that are connected, over faces of such cells, to one that has start(CellAt), too.
/// `parent`, `keep`: memory for a value of each cell. Three launches.
template <class Executor, class Set, class Start>
KeptVoxels keep_connected(const Executor& executor, const BoxGrid& grid, const Set& set, const Start& start,
                          int* parent, std::uint8_t* keep) {
  const int row = grid.row(), plane = grid.plane();
  const VoxelForest forest{parent};
  executor.each_cell(grid, [=] SIMPLEXSEG_KERNEL(const CellAt& at) {  // a run of cells in a row: its first is the root
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
    const auto is = [=](int u) { return load_relaxed(parent + u) >= 0; };
    if (!is(v)) return;
    const bool begins = at.left == 0 || !is(v - 1);
    // Where two runs are neighbours, once.
    if (at.j > 0 && is(v - row) && (begins || !is(v - row - 1))) forest.join(v, v - row);
    if (at.k > 0 && is(v - plane) && (begins || !is(v - plane - 1))) forest.join(v, v - plane);
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
