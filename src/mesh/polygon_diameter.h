// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "mesh/plane_section.h"

namespace simplexseg {

/// Segment between two boundary points of a polygon.
struct Chord {
  Eigen::Vector2d from{0, 0}, to{0, 0};
  double length() const { return (to - from).norm(); }
};

/// Diameter of a polygon: the longest segment between two of its corners, in the unit of the corners. A polygon without
/// corners has the length 0. Convex hull by Andrew's monotone chain and rotating calipers (Shamos 1978), n log n.
Chord longest_chord(const Polygon& polygon);

/// Longest segment between two boundary points of a polygon that is perpendicular to `direction`, which must not be 0.
/// For a polygon that is not convex, parts of it may lie outside. Exact, quadratic in the number of corners.
Chord longest_perpendicular_chord(const Polygon& polygon, const Eigen::Vector2d& direction);

}  // namespace simplexseg
