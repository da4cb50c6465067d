// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "evidence/field_object.h"
#include "evidence/parallel/connected.h"
#include "evidence/parallel/reduce.h"

namespace simplexseg {

/// From place x of n in a row to the nearer end.
SIMPLEXSEG_HD int steps_to_side(int x, int n) { return smaller(x, n - 1 - x); }

/// object_of_field() (evidence/field_object.h), with the same result, by a team of all threads.
struct FindObject {
  // Of `found`: where the object begins and ends on each axis, and how many voxels near the box's sides are of it.
  static constexpr int kLow = 0, kHigh = 3, kNearObject = 6, kNumbers = 7;
  static constexpr int kNone = 0x7fffffff;

  BoxGrid grid;
  const float* field;
  const Known* known;
  std::uint8_t* voxels;  ///< 0 or 1 for each voxel of the box
  int* found;
  int* parent;  ///< room for a value for each voxel, as is `keep`
  std::uint8_t* keep;

  SIMPLEXSEG_HD bool is_at_side(int v) const {
    const int i = v % grid.size[0], j = v / grid.size[0] % grid.size[1], k = v / grid.plane();
    return steps_to_side(i, grid.size[0]) == 0 || steps_to_side(j, grid.size[1]) == 0 ||
           steps_to_side(k, grid.size[2]) == 0;
  }
  SIMPLEXSEG_HD void count_row(int row) const {
    const int ni = grid.size[0], nj = grid.size[1], nk = grid.size[2], j = row % nj, k = row / nj;
    const bool near_row = smaller(steps_to_side(j, nj), steps_to_side(k, nk)) <= kNearSide;
    int low = kNone, high = -1, near_object = 0;
    for (int i = 0; i < ni; ++i) {
      if (!voxels[row * ni + i]) continue;
      if (high < 0) low = i;
      high = i;
      near_object += near_row || steps_to_side(i, ni) <= kNearSide;
    }
    if (high < 0) return;
    lower(found + kLow, low);
    lower(found + kLow + 1, j);
    lower(found + kLow + 2, k);
    raise(found + kHigh, high);
    raise(found + kHigh + 1, j);
    raise(found + kHigh + 2, k);
    if (near_object != 0) atomic_add(found + kNearObject, near_object);
  }

  template <class All>
  SIMPLEXSEG_HD void operator()(const All& all) const {
    const FindObject my = *this;
    const int n = grid.count();
    const KeptVoxels object = keep_connected(
        all, grid, [=](int v) { return my.field[v] > 0.5f; }, [=](int v) { return my.known[v] == Known::Inside; },
        parent, keep);
    all.each(n, [=](int v) { my.voxels[v] = object(v); });
    const KeptVoxels open = keep_connected(
        all, grid, [=](int v) { return my.voxels[v] == 0; },
        [=](int v) { return my.known[v] == Known::Outside || my.is_at_side(v); }, parent, keep);
    all.each(n, [=](int v) {
      my.voxels[v] = !open(v);
      if (v != 0) return;
      for (int q = 0; q < kNumbers; ++q) my.found[q] = q < kHigh ? kNone : q < kNearObject ? -1 : 0;
    });
    all.each(grid.size[1] * grid.size[2], [=](int row) { my.count_row(row); });
  }
};

/// Finds objects on an executor, of fields on a box.
template <class Executor>
class ParallelObject {
 public:
  ParallelObject(const Executor& executor, const VoxelBox& box)
      : executor_(executor),
        box_(box),
        parent_(executor.template array<int>(box.voxel_count())),
        keep_(executor.template array<std::uint8_t>(box.voxel_count())),
        found_(executor.template array<int>(FindObject::kNumbers)) {}

  struct Summary {
    VoxelBox around;      ///< as in FieldObject
    double border_share;  ///< as in FieldObject
  };
  /// What finds it, for a team of all threads; then summary().
  FindObject finder(const float* field, const Known* known, std::uint8_t* voxels) const {
    return {BoxGrid{box_.size}, field, known, voxels, found_.data(), parent_.data(), keep_.data()};
  }
  /// Of what was found last. Waits once.
  Summary summary() const {
    std::array<int, FindObject::kNumbers> found;
    executor_.download(found_.data(), std::span<int>(found));
    return summary_of(found);
  }
  Summary find(const float* field, const Known* known, std::uint8_t* voxels) const {
    executor_.all(finder(field, known, voxels));
    return summary();
  }
  std::size_t bytes() const { return parent_.bytes() + keep_.bytes() + found_.bytes(); }

 private:
  Summary summary_of(const std::array<int, FindObject::kNumbers>& found) const {
    Summary summary{{}, 0};
    double all = 1, inner = 1;
    for (int a = 0; a < 3; ++a) {
      all *= box_.size[a];
      inner *= std::max(0, box_.size[a] - 2 * (kNearSide + 1));
      if (found[FindObject::kHigh + a] < 0) continue;
      summary.around.first[a] = box_.first[a] + found[FindObject::kLow + a];
      summary.around.size[a] = found[FindObject::kHigh + a] - found[FindObject::kLow + a] + 1;
    }
    if (all > inner) summary.border_share = found[FindObject::kNearObject] / (all - inner);
    return summary;
  }

  const Executor& executor_;
  VoxelBox box_;
  typename Executor::template Array<int> parent_;
  typename Executor::template Array<std::uint8_t> keep_;
  typename Executor::template Array<int> found_;
};

}  // namespace simplexseg
