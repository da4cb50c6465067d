// SPDX-License-Identifier: Apache-2.0
#include "image/intensity_samples.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "core/error.h"

namespace simplexseg {
namespace {

/// Intensity 10 i + j in slices of 3 mm; voxels of 1 x 2 mm.
Volume ramp() {
  VolumeGeometry geometry;
  geometry.size = {20, 10, 4};
  geometry.spacing_mm = {1, 2, 3};
  Volume volume(geometry, VoxelType::Float32);
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 10; ++j)
      for (int i = 0; i < 20; ++i) volume.voxels<float>()[volume.offset(i, j, k)] = static_cast<float>(10 * i + j);
  return volume;
}

TEST(IntensitySamples, OfARectangleAreItsVoxels) {
  const IntensityRange range = range_of_rectangle(ramp(), {{{4, 2, 3}, {4, 10, 3}, {9, 10, 3}}});
  EXPECT_EQ(range.low, 41);  // i from 4 to 9, j from 1 to 5
  EXPECT_EQ(range.high, 95 - 1) << "the 99th percentile of 30 voxels is the second largest";
}

TEST(IntensitySamples, OutsideTheImageOrOfOneIntensityAreRefused) {
  const auto message = [](const Volume& volume, const std::array<Eigen::Vector3d, 3>& corners) -> std::string {
    try {
      range_of_rectangle(volume, corners);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message(ramp(), {{{-40, 2, 3}, {-40, 10, 3}, {-30, 10, 3}}}).find("fewer than nine"), std::string::npos);
  Volume constant = ramp();
  std::ranges::fill(constant.voxels<float>(), 7.0f);
  EXPECT_NE(message(constant, {{{2, 2, 3}, {2, 12, 3}, {12, 12, 3}}}).find("same intensity"), std::string::npos);
}

TEST(IntensitySamples, AHistogramCountsAllFiniteVoxels) {
  Volume volume = ramp();
  volume.voxels<float>()[5] = std::numeric_limits<float>::quiet_NaN();
  const IntensityHistogram histogram = histogram_of(volume, 16);
  EXPECT_EQ(std::accumulate(histogram.counts.begin(), histogram.counts.end(), std::size_t{0}), 799u);
  EXPECT_EQ(histogram.range.low, 0);
  EXPECT_EQ(histogram.range.high, 199);
  std::ranges::fill(volume.voxels<float>(), std::numeric_limits<float>::infinity());
  EXPECT_TRUE(histogram_of(volume, 16).counts.empty());
  std::ranges::fill(volume.voxels<float>(), 3.0f);
  EXPECT_EQ(histogram_of(volume, 4).counts[0], 800u) << "one intensity";
}

}  // namespace
}  // namespace simplexseg
