// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cmath>
#include <span>

#include "core/vec3.h"
#include "evidence/padded_array.h"

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

/// Lowers `distance` to the geodesic distance from where it is least, over the 26 neighbours. Starts: 0 at the sources
/// and anything large elsewhere, or an earlier distance with new zeros. Raster scans forth and back, at most `rounds`,
/// until nothing changes (Toivanen 1996, New geodesic distance transforms for gray-scale images; Criminisi, Sharp and
/// Blake 2008, GeoS). Where `image` is NaN no way leads through.
void lower_geodesic_distance(std::span<float> distance, std::span<const float> image, const BoxGrid& grid,
                             const std::array<double, 3>& spacing_mm, const EdgeCost& cost, int rounds);

}  // namespace simplexseg
