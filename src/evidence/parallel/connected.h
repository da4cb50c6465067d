// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "core/atomics.h"
#include "evidence/parallel/executor.h"

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

/// What keep_connected() found.
struct KeptVoxels {
  const int* parent;
  const std::uint8_t* keep;
  SIMPLEXSEG_HD bool operator()(int v) const { return parent[v] >= 0 && keep[parent[v]] != 0; }
};

/// The counterpart of keep_connected() (evidence/connected.h): the voxels set(v) of a box that are connected, over
/// faces of such voxels, to one with start(v), too. `parent`, `keep`: room for a value for each voxel. Three launches.
template <class Executor, class Set, class Start>
KeptVoxels keep_connected(const Executor& executor, const BoxGrid& grid, const Set& set, const Start& start,
                          int* parent, std::uint8_t* keep) {
  const int n = grid.count(), row = grid.row(), plane = grid.plane();
  const VoxelForest forest{parent};
  executor.each(n, [=] SIMPLEXSEG_KERNEL(int v) {  // a run of voxels in a row: its first is the root
    keep[v] = 0;
    int first = -1;
    if (set(v)) {
      first = v;
      for (const int begin = v - v % row; first > begin && set(first - 1);) --first;
    }
    parent[v] = first;
  });
  executor.each(n, [=] SIMPLEXSEG_KERNEL(int v) {
    if (parent[v] < 0) return;
    const bool begins = v % row == 0 || parent[v - 1] < 0;
    // Where two runs lie side by side, once.
    if (v % plane >= row && parent[v - row] >= 0 && (begins || parent[v - row - 1] < 0)) forest.join(v, v - row);
    if (v >= plane && parent[v - plane] >= 0 && (begins || parent[v - plane - 1] < 0)) forest.join(v, v - plane);
  });
  executor.each(n, [=] SIMPLEXSEG_KERNEL(int v) {
    if (parent[v] < 0) return;
    const int root = forest.root(v);
    parent[v] = root;
    if (start(v)) store_relaxed(keep + root, 1);
  });
  return {parent, keep};
}

}  // namespace simplexseg
