// SPDX-License-Identifier: Apache-2.0
// Statistics of intensities inside and around a mesh.
#include "forces/region_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <numeric>

#include "image/rasterise.h"
#include "image/volume.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {
namespace {

/// Cube of `size` voxels of 1 mm, centred at 0, with a ball of radius 0.2 * size: intensities 100 to 110 in the ball,
/// 10 to 30 outside.
Volume ball_volume(int size) {
  const double origin = -0.5 * (size - 1);
  Volume volume(VolumeGeometry{.size = {size, size, size}, .origin_mm = {origin, origin, origin}}, VoxelType::Int16);
  std::int16_t* const voxels = volume.voxels<std::int16_t>().data();
  for (int k = 0; k < size; ++k)
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) {
        const bool inside = Eigen::Vector3d(i + origin, j + origin, k + origin).norm() < 0.2 * size;
        const int texture = 7 * i + 13 * j + 29 * k;
        voxels[volume.offset(i, j, k)] = static_cast<std::int16_t>(inside ? 100 + texture % 11 : 10 + texture % 21);
      }
  return volume;
}
double count(const std::array<std::int32_t, kRegionBins>& bins) {
  return std::accumulate(bins.begin(), bins.end(), 0.0);
}

TEST(RegionModel, CountsTheVoxelsInsideAndAroundAMesh) {
  const RegionModel model = estimate_region(ball_volume(60), make_sphere({0, 0, 0}, 12, 4), 6);
  const double ball = 4 * std::numbers::pi / 3 * 12 * 12 * 12;
  EXPECT_NEAR(count(model.object), ball, 0.03 * ball);
  EXPECT_EQ(count(model.object) + count(model.background), 38 * 38 * 38) << "bounding box with a margin of 6 mm";
  EXPECT_GT(model.low, -30);
  EXPECT_LT(model.low, 12);
  EXPECT_GT(model.high, 108);
  EXPECT_LT(model.high, 140);
  const auto ratios = log_likelihood_ratios(model);
  const auto ratio_of = [&](double intensity) {
    return ratios[static_cast<int>((intensity - model.low) / (model.high - model.low) * (kRegionBins - 1) + 0.5)];
  };
  EXPECT_GT(ratio_of(105), 0.9f);
  EXPECT_LT(ratio_of(20), -0.9f);
}

TEST(RegionModel, SamplesALargeRegion) {
  const RegionModel small = estimate_region(ball_volume(60), make_sphere({0, 0, 0}, 12, 4), 60);
  const RegionModel large = estimate_region(ball_volume(200), make_sphere({0, 0, 0}, 40, 4), 200);
  const double ball = 4 * std::numbers::pi / 3 * 40 * 40 * 40;
  EXPECT_NEAR(count(large.object), ball, 0.03 * ball) << "all of it";
  EXPECT_GT(count(large.background), 0.7e6);
  EXPECT_LE(count(large.background), 2e6) << "of 8 million voxels";
  EXPECT_NEAR(large.low, small.low, 2);
  EXPECT_NEAR(large.high, small.high, 2);
}

TEST(RegionModel, UsesAllColumnsAndAllVoxelsOfASmallObject) {
  // 9.4 million voxels: every ninth one, in rows of nine voxels.
  Volume volume(VolumeGeometry{.size = {9, 1024, 1024}}, VoxelType::UInt8);
  std::uint8_t* const voxels = volume.voxels<std::uint8_t>().data();
  for (std::size_t n = 0; n < volume.voxels<std::uint8_t>().size(); ++n) voxels[n] = 10 + 20 * (n % 9);
  const SimplexMesh ball = make_sphere({4, 500, 500}, 3, 3);
  const RegionModel model = estimate_region(volume, ball, 2000);
  EXPECT_GT(count(model.object), 80);
  EXPECT_EQ(count(model.object), std::ranges::count(rasterise(ball, volume.geometry()).voxels, 1));
  EXPECT_EQ(std::ranges::count_if(model.background, [](int n) { return n > 50'000; }), 9);
}

TEST(RegionModel, IsEmptyWithoutVoxelsInTheMesh) {
  EXPECT_TRUE(estimate_region(ball_volume(20), SimplexMesh(), 2).empty());
  EXPECT_TRUE(estimate_region(ball_volume(20), make_sphere({50, 0, 0}, 5, 2), 2).empty());
  EXPECT_TRUE(estimate_region(Volume(), make_sphere({0, 0, 0}, 5, 2), 2).empty());
}

}  // namespace
}  // namespace simplexseg
