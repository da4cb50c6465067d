// SPDX-License-Identifier: Apache-2.0
#include "field/seed_scale.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "image/mask.h"

namespace simplexseg {
namespace {

/// Ball of intensity 150 in 50 with noise, in voxels of 1 x 1 x 2 mm; `middle`: centre of the ball.
Volume ball(double radius_mm, double noise, const Eigen::Vector3d& middle = {40, 40, 40}) {
  VolumeGeometry geometry;
  geometry.size = {80, 80, 40};
  geometry.spacing_mm = {1, 1, 2};
  Volume image(geometry, VoxelType::Float32);
  std::uint64_t state = 1;
  for (int k = 0; k < 40; ++k)
    for (int j = 0; j < 80; ++j)
      for (int i = 0; i < 80; ++i) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        const double scatter = static_cast<double>(state >> 33) / 2147483648.0 - 0.5;
        const bool in = (Eigen::Vector3d(i, j, 2 * k) - middle).norm() <= radius_mm;
        image.voxels<float>()[image.offset(i, j, k)] = static_cast<float>((in ? 150 : 50) + 3.46 * noise * scatter);
      }
  return image;
}

TEST(SeedReach, OfASmallBallExtendsToTheWall) {
  for (const double noise : {0.0, 5.0})
    for (const double radius : {8.0, 10.0}) {
      const double reach = seed_scale(ball(16, noise), {40, 40, 40}, radius).scale_mm;
      EXPECT_GT(reach, 0.85 * 16) << radius << ' ' << noise;
      EXPECT_LE(reach, 16.5) << radius << ' ' << noise;
    }
}

TEST(SeedReach, OfALargeEnoughBallIsItsRadius) {
  for (const double radius : {14.0, 16.0, 20.0})
    EXPECT_DOUBLE_EQ(seed_scale(ball(16, 5), {40, 40, 40}, radius).scale_mm, radius);
}

TEST(SeedReach, IsAtMostTwice) { EXPECT_DOUBLE_EQ(seed_scale(ball(16, 5), {40, 40, 40}, 6.0).scale_mm, 12.0); }

TEST(SeedReach, WithoutAWallIsTheRadius) {
  const SeedScale scale = seed_scale(ball(200, 5), {40, 40, 40}, 8);
  EXPECT_DOUBLE_EQ(scale.scale_mm, 8);
  EXPECT_FALSE(scale.has_edges);
  EXPECT_TRUE(seed_scale(ball(16, 5), {40, 40, 40}, 8).has_edges);
}

TEST(SeedReach, VoxelsThatAreNotFiniteAreAWall) {
  Volume image = ball(200, 5);
  const Volume like = ball(16, 0);
  for (std::size_t v = 0; v < image.voxels<float>().size(); ++v)
    if (like.voxels<float>()[v] < 100) image.voxels<float>()[v] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NEAR(seed_scale(image, {40, 40, 40}, 9).scale_mm, 0.85 * 16, 1.5);
  for (float& x : image.voxels<float>()) x = std::numeric_limits<float>::infinity();
  EXPECT_DOUBLE_EQ(seed_scale(image, {40, 40, 40}, 9).scale_mm, 9);
}

}  // namespace
}  // namespace simplexseg
