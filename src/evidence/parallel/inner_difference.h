// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "evidence/conductances.h"
#include "evidence/marked_voxels.h"
#include "evidence/parallel/select.h"

namespace simplexseg {

/// Differences of neighbours within the inside marks: three to a voxel, one along each axis; -1 where there is none.
struct InnerDifference {
  const float* image;
  const Constraint* known;
  int count;
  int stride[3];
  bool heard[3];  ///< the axis

  SIMPLEXSEG_HD float operator()(int item) const {
    const int v = item / 3, a = item % 3, u = v + stride[a];
    if (!heard[a] || u >= count || known[v] != Constraint::Inside || known[u] != Constraint::Inside) return -1;
    return std::fabs(image[u] - image[v]);
  }
};

/// inner_difference() (evidence/conductances.h) of arrays of the executor: fetched, and received when it is needed.
template <class Executor>
typename Executor::template Fetched<Selected> fetch_inner_difference(const Executor& executor, const BoxGrid& grid,
                                                                     const std::array<double, 3>& spacing_mm,
                                                                     const float* image, const Constraint* known) {
  const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
  InnerDifference difference{image, known, grid.count(), {}, {}};
  for (int a = 0; a < 3; ++a) {
    difference.stride[a] = grid.stride(a);
    difference.heard[a] = spacing_mm[a] < 2 * least && grid.size[a] > 1;
  }
  return executor.fetch(
      select_quantile(executor, 3 * grid.count(), difference, kShareOfDifferences, kLeastDifferences).data(), 1);
}
template <class Executor>
float received_inner_difference(const Executor& executor,
                                const typename Executor::template Fetched<Selected>& fetched) {
  return received<Selected>(executor, fetched).value_or(0);
}

}  // namespace simplexseg
