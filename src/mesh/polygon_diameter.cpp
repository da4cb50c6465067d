// SPDX-License-Identifier: Apache-2.0
#include "mesh/polygon_diameter.h"

#include <algorithm>
#include <limits>

#include "core/expect.h"

namespace simplexseg {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a[0] * b[1] - a[1] * b[0]; }

/// Corners of the convex hull, counter-clockwise, without collinear ones (Andrew's monotone chain).
Polygon convex_hull(Polygon corners) {
  std::sort(corners.begin(), corners.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a[0] != b[0] ? a[0] < b[0] : a[1] < b[1];
  });
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  if (corners.size() < 3) return corners;
  Polygon hull;
  const auto add_chain = [&hull](auto first, auto last) {
    const std::size_t start = hull.size();
    for (; first != last; ++first) {
      while (hull.size() >= start + 2 && cross(hull.back() - hull[hull.size() - 2], *first - hull.back()) <= 0)
        hull.pop_back();
      hull.push_back(*first);
    }
    hull.pop_back();  // the first corner of the next chain
  };
  add_chain(corners.begin(), corners.end());
  add_chain(corners.rbegin(), corners.rend());
  return hull;
}

}  // namespace

Chord longest_chord(const Polygon& polygon) {
  const Polygon hull = convex_hull(polygon);
  Chord longest;
  if (hull.empty()) return longest;
  longest = {hull.front(), hull.front()};
  double squared = 0;
  const auto compare = [&](std::size_t a, std::size_t b) {
    const double length = (hull[a] - hull[b]).squaredNorm();
    if (length > squared) squared = length, longest = {hull[a], hull[b]};
  };
  const std::size_t count = hull.size();
  if (count == 2) compare(0, 1);
  if (count < 3) return longest;
  std::size_t across = 1;
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t next = (n + 1) % count;
    const Eigen::Vector2d edge = hull[next] - hull[n];
    // Advances to the corner farthest from the edge; parallel edges give two such corners.
    while (cross(edge, hull[(across + 1) % count] - hull[across]) > 0) {
      compare(n, across);
      across = (across + 1) % count;
    }
    for (const std::size_t end : {n, next})
      for (const std::size_t far : {across, (across + 1) % count}) compare(end, far);
  }
  return longest;
}

Chord longest_perpendicular_chord(const Polygon& polygon, const Eigen::Vector2d& direction) {
  SIMPLEXSEG_EXPECT(direction.norm() > 0);
  const Eigen::Vector2d along = direction.normalized(), across(-along[1], along[0]);
  Chord longest;
  double best = -1;
  // Between two corners, the length is linear in the position along the direction, so its maximum lies at a corner.
  for (const Eigen::Vector2d& corner : polygon) {
    const double at = along.dot(corner);
    double low = across.dot(corner), high = low;
    for (std::size_t n = 0, before = polygon.size() - 1; n < polygon.size(); before = n++) {
      const double a = along.dot(polygon[before]), b = along.dot(polygon[n]);
      if (at < std::min(a, b) || at > std::max(a, b)) continue;
      const double from = across.dot(polygon[before]), to = across.dot(polygon[n]);
      const double there = a == b ? to : from + (at - a) / (b - a) * (to - from);
      low = std::min(low, there), high = std::max(high, there);
    }
    if (high - low <= best) continue;
    best = high - low;
    longest = {at * along + low * across, at * along + high * across};
  }
  return longest;
}

}  // namespace simplexseg
