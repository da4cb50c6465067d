// SPDX-License-Identifier: Apache-2.0
// Statistics of intensities inside and around a mesh.
#include "forces/region_model.h"

#include <gtest/gtest.h>

#include <numbers>
#include <numeric>

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
  const double samples = count(large.object) + count(large.background);
  EXPECT_LE(samples, 1.1e6) << "of 8 million voxels";
  EXPECT_GT(samples, 0.7e6);
  const double share = count(small.object) / (count(small.object) + count(small.background));
  EXPECT_NEAR(count(large.object) / samples, share, 0.03 * share);
  EXPECT_NEAR(large.low, small.low, 2);
  EXPECT_NEAR(large.high, small.high, 2);
}

TEST(RegionModel, IsEmptyWithoutVoxelsInTheMesh) {
  EXPECT_TRUE(estimate_region(ball_volume(20), make_sphere({50, 0, 0}, 5, 2), 2).empty());
  EXPECT_TRUE(estimate_region(Volume(), make_sphere({0, 0, 0}, 5, 2), 2).empty());
}

}  // namespace
}  // namespace simplexseg
