// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>

#include "core/vec3.h"

namespace simplexseg {

/// What the way from a voxel to its neighbour costs, d being the difference of the image there: |d|, or with an `edge`
/// above 0 d^2 / (d^2 + edge^2), so that every edge counts once however strong it is; and `length` times their distance
/// in units of the least spacing.
struct EdgeCost {
  float length = 0;
  float edge = 0;
};

/// What a difference of neighbours costs; `edge2`: the edge's square, or 0 where |d| is meant.
template <bool kEdges>
SIMPLEXSEG_HD float cost_of_difference(float difference, float edge2) {
  if constexpr (!kEdges) return std::fabs(difference);
  const float square = difference * difference;
  return square / (square + edge2);
}

}  // namespace simplexseg
