// SPDX-License-Identifier: Apache-2.0
// Planes of contours from the positions of the contours along their normal.
#pragma once
#include <cstddef>
#include <vector>

namespace simplexseg {

/// Positions of parallel planes along their normal, sorted.
struct PlanePositions {
  std::vector<double> planes;
  std::vector<std::size_t> plane_of;  ///< index of the plane of each input position

  /// Returns the lower median of the distances between neighbouring planes, which missing planes do not change; 0 for
  /// fewer than two planes.
  double distance() const;
};

/// Returns the median, the lower of two for an even number of values; 0 without values.
double lower_median(std::vector<double> values);

/// Groups positions into planes: those within `tolerance` of the first one in a plane are of this plane.
PlanePositions planes_of(const std::vector<double>& positions, double tolerance);

/// Returns the tolerance for planes_of() where the distance of the planes is unknown: 1% of it, but from `noise`, the
/// largest distance that certainly comes from rounding, to `limit`, the largest that can. The distance is estimated as
/// the median of the gaps that exceed 1% of the largest. If positions within the tolerance form chains, they are planes
/// themselves, the large gaps are parts without contours, and the estimate is repeated without them.
double plane_tolerance(std::vector<double> positions, double noise, double limit);

}  // namespace simplexseg
