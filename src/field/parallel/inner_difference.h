// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "field/conductances.h"
#include "field/marked_voxels.h"
#include "field/parallel/select.h"

namespace simplexseg {

/// Differences of neighbours within the inside marks: three items for each cell, one per axis; -1 for no such pair.
struct InnerDifference {
  const float* image;
  const Constraint* constraints;
  int size[3], stride[3];  ///< of the box
  bool used[3];            ///< whether the axis is used
  int first[3];            ///< of the part of the box that contains the marks
  BoxGrid part;

  SIMPLEXSEG_HD float operator()(int item) const {
    const int a = item % 3;
    const CellAt at = cell_at(part, item / 3);
    const int place[3]{at.i + first[0], at.j + first[1], at.k + first[2]};
    const int v = place[0] + place[1] * stride[1] + place[2] * stride[2], u = v + stride[a];
    if (!used[a] || place[a] + 1 >= size[a] || constraints[v] != Constraint::Inside ||
        constraints[u] != Constraint::Inside)
      return -1;
    return std::fabs(image[u] - image[v]);
  }
};

/// Begins the download of the inner difference: 75th percentile of |intensity difference| between neighbours that are
/// both in inside marks, along axes with a spacing below twice the smallest. 0 with fewer than 20 pairs. `part`: box
/// that contains all inside marks.
template <class Executor>
typename Executor::template Fetched<Selected> fetch_inner_difference(const Executor& executor, const BoxGrid& grid,
                                                                     const std::array<double, 3>& spacing_mm,
                                                                     const float* image, const Constraint* constraints,
                                                                     const VoxelBox& part) {
  const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
  InnerDifference difference{image, constraints, {}, {}, {}, {}, BoxGrid{part.size}};
  for (int a = 0; a < 3; ++a) {
    difference.size[a] = grid.size[a];
    difference.stride[a] = grid.stride(a);
    difference.first[a] = part.first[a];
    difference.used[a] = spacing_mm[a] < 2 * least && grid.size[a] > 1;
  }
  return executor.fetch(
      select_quantile(executor, 3 * difference.part.count(), difference, kShareOfDifferences, kLeastDifferences).data(),
      1);
}
/// Waits for the inner difference.
template <class Executor>
float received_inner_difference(const Executor& executor,
                                const typename Executor::template Fetched<Selected>& fetched) {
  return received<Selected>(executor, fetched).value_or(0);
}

}  // namespace simplexseg
