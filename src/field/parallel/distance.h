// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cmath>
#include <cstdint>

#include "field/parallel/executor.h"

namespace simplexseg {

inline constexpr float kFarAway = 3e38f;  ///< the square of a distance that was not found

/// One axis of the squares of distances between voxels of a set and the others: the least that a voxel's line holds, of
/// what the axes before found, outward until nothing nearer can come.
struct DistancePass {
  const std::uint8_t* set;  ///< 0: not of the set
  const float* before;      ///< squares of the axes before; null: there is none
  float* to;
  int axis, stride, length;
  float step_mm, reach_mm;
  bool both_sides;  ///< else only of voxels that are not of the set, and 0 for those that are
  float less_mm;    ///< not below 0: the distance less this is written, not its square

  SIMPLEXSEG_HD float through(int q, bool is) const {
    if ((set[q] != 0) != is) return 0;
    return before ? before[q] : kFarAway;
  }
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    const int v = at.v;
    const bool is = set[v] != 0;
    if (is && !both_sides) {
      to[v] = 0;
      return;
    }
    const int x = axis == 0 ? at.i : axis == 1 ? at.j : at.k, behind = length - 1 - x;
    float least = before ? before[v] : kFarAway;
    for (int d = 1; d <= x || d <= behind; ++d) {
      const float away = step_mm * static_cast<float>(d), square = away * away;
      if (away >= reach_mm || square >= least) break;
      if (d <= x) least = smaller(square + through(v - d * stride, is), least);
      if (d <= behind) least = smaller(square + through(v + d * stride, is), least);
    }
    to[v] = less_mm >= 0 ? std::sqrt(least) - less_mm : least;
  }
};

/// One pass along each axis, the last of which writes what DistancePass::less_mm says.
template <class Executor>
void run_distance_passes(const Executor& executor, const std::uint8_t* set, const BoxGrid& grid,
                         const std::array<double, 3>& spacing_mm, float reach_mm, bool both_sides, float less_mm,
                         float* to, float* spare) {
  const float* before = nullptr;
  for (int axis = 0; axis < 3; ++axis) {
    float* const into = axis == 1 ? spare : to;
    executor.each_cell(
        grid, DistancePass{set, before, into, axis, grid.stride(axis), grid.size[axis],
                           static_cast<float>(spacing_mm[axis]), reach_mm, both_sides, axis == 2 ? less_mm : -1.0f});
    before = into;
  }
}

/// The square of the distance, mm, from every voxel of a box to the nearest one on the other side: of `set` for those
/// that are not, and with `both_sides` the other way round. Exact below reach_mm, kFarAway or any square beyond. Three
/// launches; `spare`: room for as many. Source: Saito and Toriwaki 1994, New algorithms for Euclidean distance
/// transformation of an n-dimensional digitized picture with applications.
template <class Executor>
void squared_distance_to_other_side(const Executor& executor, const std::uint8_t* set, const BoxGrid& grid,
                                    const std::array<double, 3>& spacing_mm, float reach_mm, bool both_sides, float* to,
                                    float* spare) {
  run_distance_passes(executor, set, grid, spacing_mm, reach_mm, both_sides, -1, to, spare);
}

/// Distance from every voxel to the surface of a set, mm, half of `voxel_mm` being between a voxel beside it and the
/// surface; exact up to `reach_mm`, and above it beyond. Launches and `spare` as above.
template <class Executor>
void distance_to_surface(const Executor& executor, const std::uint8_t* set, const BoxGrid& grid,
                         const std::array<double, 3>& spacing_mm, float voxel_mm, float reach_mm, float* to,
                         float* spare) {
  run_distance_passes(executor, set, grid, spacing_mm, reach_mm + voxel_mm, true, voxel_mm / 2, to, spare);
}

}  // namespace simplexseg
