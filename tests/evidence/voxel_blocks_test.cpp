// SPDX-License-Identifier: Apache-2.0
#include "evidence/voxel_blocks.h"

#include <gtest/gtest.h>

#include <vector>

namespace simplexseg {
namespace {

const BoxGrid kFine{{7, 5, 6}};
const VoxelBlocks kBlocks(kFine, {3, 2, 1});  // the last of a row and of a column are narrower

std::vector<float> of_index(const BoxGrid& grid, float x, float y, float z) {
  std::vector<float> values;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i)
        values.push_back(x * static_cast<float>(i) + y * static_cast<float>(j) + z * static_cast<float>(k));
  return values;
}

TEST(VoxelBlocks, CoverTheBox) {
  EXPECT_EQ(kBlocks.coarse.size, (std::array{3, 3, 6}));
  std::vector<int> block_of(kFine.count(), -1), voxels(kBlocks.coarse.count());
  kBlocks.visit(run_in_turn(), [&](int block, int voxel) {
    EXPECT_EQ(block_of[voxel], -1);
    block_of[voxel] = block;
    ++voxels[block];
  });
  EXPECT_EQ(block_of[(4 * 5 + 3) * 7 + 5], (4 * 3 + 1) * 3 + 1);
  EXPECT_EQ(voxels.front(), 6);
  EXPECT_EQ(voxels.back(), 1);
}

TEST(VoxelBlocks, MeanIsThatOfTheirVoxels) {
  const std::vector<float> mean = kBlocks.mean(of_index(kFine, 1, 10, 100), run_in_turn());
  EXPECT_FLOAT_EQ(mean[0], 1 + 5);
  EXPECT_FLOAT_EQ(mean[(2 * 3 + 1) * 3 + 1], 4 + 25 + 200);
  EXPECT_FLOAT_EQ(mean[2], 6 + 5);  // of a single column
}

TEST(VoxelBlocks, InterpolationIsLinearBetweenTheirMiddlesAndConstantBeyond) {
  std::vector<std::uint8_t> blocks, voxels(kFine.count());
  for (const float x : of_index(kBlocks.coarse, 30, 20, 10)) blocks.push_back(static_cast<std::uint8_t>(x));
  const std::vector<float> dark(kFine.count()), dark_blocks(blocks.size());
  kBlocks.interpolate(blocks, {dark, dark_blocks, 0.1f}, voxels, run_in_turn());
  const auto at = [&](int i, int j, int k) { return voxels[(k * 5 + j) * 7 + i]; };
  EXPECT_EQ(at(0, 0, 0), 0);
  EXPECT_EQ(at(1, 0, 2), 20);
  EXPECT_EQ(at(2, 0, 0), 10);
  EXPECT_EQ(at(4, 1, 0), 30 + 5);
  EXPECT_EQ(at(6, 4, 5), 50 + 35 + 50);  // a narrow block counts like a full one
}

TEST(VoxelBlocks, AVoxelGetsValuesOfBlocksOfSimilarIntensity) {
  std::vector<float> image(kFine.count());
  for (int v = 0; v < kFine.count(); ++v) image[v] = v % 7 < 4 ? 0 : 1;  // an edge within a block
  const std::vector<float> mean = kBlocks.mean(image, run_in_turn());
  std::vector<std::uint8_t> blocks, voxels(kFine.count());
  for (int b = 0; b < kBlocks.coarse.count(); ++b) blocks.push_back(b % 3 == 0 ? 0 : b % 3 == 1 ? 170 : 255);
  const auto change_at = [&](int i) { return voxels[i] - voxels[i - 1]; };
  kBlocks.interpolate(blocks, {image, mean, 100}, voxels, run_in_turn());
  const int blurred = change_at(4);
  EXPECT_EQ(voxels[4], 170);
  kBlocks.interpolate(blocks, {image, mean, 0.1f}, voxels, run_in_turn());
  EXPECT_GT(change_at(4), blurred);
  EXPECT_LT(voxels[2], 60);
}

TEST(VoxelBlocks, GeometryPutsEachInTheMiddleOfItsVoxels) {
  VolumeGeometry geometry;
  geometry.size = {20, 20, 20};
  geometry.spacing_mm = {1, 2, 3};
  geometry.origin_mm = {-5, 4, 7};
  const VolumeGeometry blocks = kBlocks.geometry(geometry, {4, 2, 1});
  EXPECT_EQ(blocks.size, kBlocks.coarse.size);
  const Eigen::Vector3d middle = blocks.world_from_index() * Eigen::Vector3d(1, 1, 2);
  const Eigen::Vector3d voxels = geometry.world_from_index() * Eigen::Vector3d(4 + 4, 2 + 2.5, 1 + 2);
  EXPECT_LT((middle - voxels).norm(), 1e-12);
}

TEST(VoxelBlocks, OfOneVoxelAreTheVoxels) {
  const VoxelBlocks same(kFine, {1, 1, 1});
  const std::vector<float> values = of_index(kFine, 3, 2, 1);
  EXPECT_EQ(same.mean(values, run_in_turn()), values);
  const std::vector<std::uint8_t> bytes(values.begin(), values.end());
  std::vector<std::uint8_t> back(bytes.size());
  same.interpolate(bytes, {values, values, 1}, back, run_in_turn());
  EXPECT_EQ(back, bytes);
}

}  // namespace
}  // namespace simplexseg
