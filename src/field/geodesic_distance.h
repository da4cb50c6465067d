// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>

#include "core/vec3.h"

namespace simplexseg {

/// Edge cost between 26-neighbours with the intensity difference d: |d|, or d^2 / (d^2 + edge^2) for `edge` > 0, which
/// counts edges whatever their contrast; plus `length` times their distance in units of the smallest spacing.
struct EdgeCost {
  float length = 0;
  float edge = 0;
};

/// Cost of an intensity difference of neighbours. `edge2`: square of EdgeCost::edge; ignored without kEdges.
template <bool kEdges>
SIMPLEXSEG_HD float cost_of_difference(float difference, float edge2) {
  if constexpr (!kEdges) return std::fabs(difference);
  const float square = difference * difference;
  return square / (square + edge2);
}

}  // namespace simplexseg
