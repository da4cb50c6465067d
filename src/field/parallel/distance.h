// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cmath>
#include <cstdint>

#include "field/parallel/executor.h"

namespace simplexseg {

inline constexpr float kFarAway = 3e38f;  ///< squared distance that was not found

/// Pass along one axis of a squared distance transform between a set of voxels and the others: the minimum over the
/// line of a voxel of the squared offset plus the result of earlier axes, searched outward until no smaller sum can
/// follow.
struct DistancePass {
  const std::uint8_t* set;  ///< not 0 in the set
  const float* earlier;     ///< result of the earlier axes; null for the first
  float* to;
  int axis, stride, length;
  float step_mm, limit_mm;
  bool both_sides;  ///< else 0 is written for voxels of the set
  float less_mm;    ///< >= 0: the distance less this is written instead of its square

  SIMPLEXSEG_HD float candidate(int u, bool in_set) const {
    if ((set[u] != 0) != in_set) return 0;
    return earlier ? earlier[u] : kFarAway;
  }
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    const int v = at.v;
    const bool in_set = set[v] != 0;
    if (in_set && !both_sides) {
      to[v] = 0;
      return;
    }
    const int x = axis == 0 ? at.i : axis == 1 ? at.j : at.k, after = length - 1 - x;
    float least = earlier ? earlier[v] : kFarAway;
    for (int d = 1; d <= x || d <= after; ++d) {
      const float away = step_mm * static_cast<float>(d), square = away * away;
      if (away >= limit_mm || square >= least) break;
      if (d <= x) least = smaller(square + candidate(v - d * stride, in_set), least);
      if (d <= after) least = smaller(square + candidate(v + d * stride, in_set), least);
    }
    to[v] = less_mm >= 0 ? std::sqrt(least) - less_mm : least;
  }
};

/// Runs a pass along each axis; DistancePass::less_mm applies to the last one.
template <class Executor>
void run_distance_passes(const Executor& executor, const std::uint8_t* set, const BoxGrid& grid,
                         const std::array<double, 3>& spacing_mm, float limit_mm, bool both_sides, float less_mm,
                         float* to, float* scratch) {
  const float* earlier = nullptr;
  for (int axis = 0; axis < 3; ++axis) {
    float* const into = axis == 1 ? scratch : to;
    executor.each_cell(
        grid, DistancePass{set, earlier, into, axis, grid.stride(axis), grid.size[axis],
                           static_cast<float>(spacing_mm[axis]), limit_mm, both_sides, axis == 2 ? less_mm : -1.0f});
    earlier = into;
  }
}

/// Squared distance, mm^2, from each voxel outside `set` to the nearest one in it, and with `both_sides` from each
/// voxel in it to the nearest one outside. Exact below limit_mm; beyond, any larger square or kFarAway. `scratch`:
/// workspace of a value for each voxel. Three launches. Source: Saito and Toriwaki 1994, New algorithms for Euclidean
/// distance transformation of an n-dimensional digitized picture with applications.
template <class Executor>
void squared_distance_to_other_side(const Executor& executor, const std::uint8_t* set, const BoxGrid& grid,
                                    const std::array<double, 3>& spacing_mm, float limit_mm, bool both_sides, float* to,
                                    float* scratch) {
  run_distance_passes(executor, set, grid, spacing_mm, limit_mm, both_sides, -1, to, scratch);
}

/// Distance from each voxel to the surface of a set, mm: half of `voxel_mm` for voxels beside it. Exact up to
/// `limit_mm`; beyond, any larger value. `scratch`: workspace of a value for each voxel. Three launches.
template <class Executor>
void distance_to_surface(const Executor& executor, const std::uint8_t* set, const BoxGrid& grid,
                         const std::array<double, 3>& spacing_mm, float voxel_mm, float limit_mm, float* to,
                         float* scratch) {
  run_distance_passes(executor, set, grid, spacing_mm, limit_mm + voxel_mm, true, voxel_mm / 2, to, scratch);
}

}  // namespace simplexseg
