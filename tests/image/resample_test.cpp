// SPDX-License-Identifier: Apache-2.0
#include "image/resample.h"

#include <gtest/gtest.h>

namespace simplexseg {
namespace {

/// Volume of 8 x 6 x 4 voxels of 1 x 2 x 3 mm, whose values are their offsets.
Volume numbered() {
  VolumeGeometry geometry;
  geometry.size = {8, 6, 4};
  geometry.spacing_mm = {1, 2, 3};
  geometry.origin_mm = {10, -20, 30};
  Volume volume(geometry, VoxelType::UInt8);
  std::uint8_t value = 0;
  for (std::uint8_t& v : volume.voxels<std::uint8_t>()) v = value++;
  return volume;
}

TEST(Resample, AxisPermutationsAndReversalsAreLossless) {
  const Volume labels = numbered();
  // i is reversed, j and k are exchanged.
  VolumeGeometry grid = labels.geometry();
  grid.size = {8, 4, 6};
  grid.spacing_mm = {1, 3, 2};
  grid.origin_mm = {17, -20, 30};
  grid.direction << -1, 0, 0, 0, 0, 1, 0, 1, 0;
  const ResampledLabels result = resample_labels(labels, grid);
  EXPECT_EQ(result.outside, 0u);
  EXPECT_EQ(result.labelled, labels.geometry().voxel_count() - 1);
  EXPECT_TRUE(result.labels.geometry().same_grid(grid, 0));
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 6; ++j) {
      for (int i = 0; i < 8; ++i) ASSERT_EQ(result.labels.value(7 - i, k, j), labels.value(i, j, k));
    }
  }
}

TEST(Resample, EachVoxelTakesTheLabelAtItsCentre) {
  const Volume labels = numbered();
  VolumeGeometry fine = labels.geometry();
  fine.size = {16, 12, 8};
  fine.spacing_mm /= 2;
  fine.origin_mm -= 0.5 * fine.spacing_mm;  // keeps the outer faces
  const ResampledLabels doubled = resample_labels(labels, fine);
  for (int k = 0; k < 8; ++k) {
    for (int j = 0; j < 12; ++j) {
      for (int i = 0; i < 16; ++i) ASSERT_EQ(doubled.labels.value(i, j, k), labels.value(i / 2, j / 2, k / 2));
    }
  }
  const ResampledLabels back = resample_labels(doubled.labels, labels.geometry());
  for (int i = 0; i < 8; ++i) EXPECT_EQ(back.labels.value(i, 3, 2), labels.value(i, 3, 2));
}

TEST(Resample, LabelledVoxelsOutsideTheGridAreCounted) {
  const Volume labels = numbered();
  VolumeGeometry part = labels.geometry();
  part.origin_mm.x() += 5;  // five of eight columns are lost
  const ResampledLabels result = resample_labels(labels, part);
  EXPECT_EQ(result.outside, 5u * 6 * 4 - 1);  // the first voxel is 0
  EXPECT_EQ(result.labels.value(0, 0, 0), 5);
  EXPECT_EQ(result.labels.value(2, 5, 3), labels.value(7, 5, 3));
  EXPECT_EQ(result.labels.value(3, 5, 3), 0);
}

}  // namespace
}  // namespace simplexseg
