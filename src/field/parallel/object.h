// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "field/field_object.h"
#include "field/parallel/connected.h"
#include "field/parallel/reduce.h"

namespace simplexseg {

/// Number of cells between index x of n along an axis and the nearer side of the box; an axis of one cell has no sides.
SIMPLEXSEG_HD int steps_to_side(int x, int n) { return n < 3 ? 0x7fffffff : smaller(x, n - 1 - x); }

/// Computes the object mask of a field (FieldObject).
template <class Executor>
class ParallelObject {
 public:
  ParallelObject(const Executor& executor, const VoxelBox& box)
      : executor_(executor),
        box_(box),
        parent_(executor.template array<int>(box.voxel_count())),
        keep_(executor.template array<std::uint8_t>(box.voxel_count())),
        found_(executor.template array<int>(kNumbers)) {}

  struct Summary {
    VoxelBox bounds;      ///< as in FieldObject
    std::size_t count;    ///< as in FieldObject
    double border_share;  ///< as in FieldObject
  };
  /// Writes the mask, 0 or 1 for each voxel of the box, to `voxels`. Waits once.
  Summary find(const float* field, const Constraint* constraints, std::uint8_t* voxels) {
    const BoxGrid grid{box_.size};
    const int n = grid.count(), ni = box_.size[0], nj = box_.size[1], nk = box_.size[2];
    int* const found = found_.data();
    const KeptVoxels object = keep_connected(
        executor_, grid, [=] SIMPLEXSEG_KERNEL(const CellAt& at) { return field[at.v] > 0.5f; },
        [=] SIMPLEXSEG_KERNEL(const CellAt& at) { return constraints[at.v] == Constraint::Inside; }, parent_.data(),
        keep_.data());
    executor_.each(n, [=] SIMPLEXSEG_KERNEL(int v) {
      voxels[v] = object(v);
      if (v != 0) return;
      for (int q = 0; q < kNumbers; ++q) found[q] = q < kHigh ? kNone : q < kNearObject ? -1 : 0;
    });
    const KeptVoxels open = keep_connected(
        executor_, grid, [=] SIMPLEXSEG_KERNEL(const CellAt& at) { return voxels[at.v] == 0; },
        [=] SIMPLEXSEG_KERNEL(const CellAt& at) {
          return is_excluded_by_mark(constraints[at.v]) || steps_to_side(at.i, ni) == 0 ||
                 steps_to_side(at.j, nj) == 0 || steps_to_side(at.k, nk) == 0;
        },
        parent_.data(), keep_.data());
    // Beginnings and ends of the runs of the object, and its voxels near the sides of the box.
    executor_.each_cell(grid, [=] SIMPLEXSEG_KERNEL(const CellAt& at) {
      const int i = at.i, j = at.j, k = at.k, v = at.v;
      const bool in_object = !open(v);
      voxels[v] = in_object;
      if (!in_object) return;
      if (i == 0 || open(v - 1)) {
        lower(found + kLow, i);
        lower(found + kLow + 1, j);
        lower(found + kLow + 2, k);
        raise(found + kHigh + 1, j);
        raise(found + kHigh + 2, k);
        atomic_add(found + kCount, -i);
      }
      if (i + 1 == ni || open(v + 1)) {
        raise(found + kHigh, i);
        atomic_add(found + kCount, i + 1);
      }
      if (smaller(smaller(steps_to_side(i, ni), steps_to_side(j, nj)), steps_to_side(k, nk)) <= kNearSide)
        atomic_add(found + kNearObject, 1);
    });
    std::array<int, kNumbers> on_host;
    executor_.download(found, std::span<int>(on_host));
    return summary_of(on_host);
  }
  std::size_t bytes() const { return parent_.bytes() + keep_.bytes() + found_.bytes(); }

 private:
  // Elements of found_: first and last index of the object on each axis, number of its voxels near the sides of the
  // box, number of all its voxels.
  static constexpr int kLow = 0, kHigh = 3, kNearObject = 6, kCount = 7, kNumbers = 8;
  static constexpr int kNone = 0x7fffffff;

  Summary summary_of(const std::array<int, kNumbers>& found) const {
    Summary summary{{}, static_cast<std::size_t>(found[kCount]), 0};
    double all = 1, inner = 1;
    for (int a = 0; a < 3; ++a) {
      all *= box_.size[a];
      inner *= box_.size[a] < 3 ? box_.size[a] : std::max(0, box_.size[a] - 2 * (kNearSide + 1));
      if (found[kHigh + a] < 0) continue;
      summary.bounds.first[a] = box_.first[a] + found[kLow + a];
      summary.bounds.size[a] = found[kHigh + a] - found[kLow + a] + 1;
    }
    if (all > inner) summary.border_share = found[kNearObject] / (all - inner);
    return summary;
  }

  const Executor& executor_;
  VoxelBox box_;
  typename Executor::template Array<int> parent_;
  typename Executor::template Array<std::uint8_t> keep_;
  typename Executor::template Array<int> found_;
};

}  // namespace simplexseg
