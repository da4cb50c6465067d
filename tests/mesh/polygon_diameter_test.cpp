// SPDX-License-Identifier: Apache-2.0
#include "mesh/polygon_diameter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace simplexseg {
namespace {

/// Star-shaped polygon with random radii, not convex.
Polygon random_polygon(std::mt19937& random, int corners) {
  std::uniform_real_distribution<double> radius(2, 9), stretch(0.3, 3);
  const double wide = stretch(random), turn = stretch(random);
  Polygon polygon;
  for (int n = 0; n < corners; ++n) {
    const double angle = 2 * std::numbers::pi * n / corners, r = radius(random);
    polygon.push_back(Eigen::Rotation2Dd(turn) * Eigen::Vector2d(wide * r * std::cos(angle), r * std::sin(angle)));
  }
  return polygon;
}

TEST(PolygonDiameter, OfRandomPolygonsIsThatOfAllPairsOfCorners) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 400; ++trial) {
    const Polygon polygon = random_polygon(random, 3 + trial % 60);
    double longest = 0;
    for (const Eigen::Vector2d& a : polygon)
      for (const Eigen::Vector2d& b : polygon) longest = std::max(longest, (a - b).norm());
    EXPECT_DOUBLE_EQ(longest_chord(polygon).length(), longest) << trial;
  }
}

TEST(PolygonDiameter, OfParallelEdgesRepeatedAndCollinearCorners) {
  const Polygon rectangle{{0, 0}, {2, 0}, {4, 0}, {4, 0}, {4, 3}, {0, 3}, {0, 1}};
  EXPECT_DOUBLE_EQ(longest_chord(rectangle).length(), 5);
  EXPECT_DOUBLE_EQ(longest_chord({{0, 0}, {1, 1}, {3, 3}}).length(), std::sqrt(18));
  EXPECT_EQ(longest_chord({{5, 5}}).length(), 0);
  EXPECT_EQ(longest_chord({}).length(), 0);
}

TEST(PerpendicularChord, OfRandomPolygonsIsNotExceededByDenseLines) {
  std::mt19937 random(8);
  for (int trial = 0; trial < 60; ++trial) {
    const Polygon polygon = random_polygon(random, 3 + trial);
    const Eigen::Vector2d along = Eigen::Rotation2Dd(0.1 * trial) * Eigen::Vector2d(1, 0), across(-along[1], along[0]);
    const Chord chord = longest_perpendicular_chord(polygon, 3 * along);
    EXPECT_NEAR((chord.to - chord.from).dot(along), 0, 1e-9);
    double dense = 0;
    for (double at = -30; at < 30; at += 0.003) {
      double low = INFINITY, high = -INFINITY;
      for (std::size_t n = 0; n < polygon.size(); ++n) {
        const Eigen::Vector2d &a = polygon[n], &b = polygon[(n + 1) % polygon.size()];
        const double from = along.dot(a) - at, to = along.dot(b) - at;
        if ((from > 0) == (to > 0)) continue;
        const double there = across.dot(a + from / (from - to) * (b - a));
        low = std::min(low, there), high = std::max(high, there);
      }
      dense = std::max(dense, high - low);
    }
    EXPECT_GE(chord.length(), dense - 1e-9) << trial;
    EXPECT_LE(chord.length(), dense + 0.1) << trial;
  }
}

TEST(PerpendicularChord, IsAChordAndNotTheWidth) {
  // The width of this parallelogram across its long diagonal is larger than any chord across it.
  const Polygon parallelogram{{0, 0}, {10, 0}, {14, 4}, {4, 4}};
  const Chord longest = longest_chord(parallelogram);
  EXPECT_DOUBLE_EQ(longest.length(), std::sqrt(14 * 14 + 16));
  const Chord chord = longest_perpendicular_chord(parallelogram, longest.to - longest.from);
  // Chord through (10, 0) or (4, 4), perpendicular to (14, 4): from (4, 4) to y = 0 at (4 + 8 / 7, 0).
  EXPECT_NEAR(chord.length(), std::hypot(4, 8.0 / 7), 1e-12);
}

}  // namespace
}  // namespace simplexseg
