// SPDX-License-Identifier: Apache-2.0
#include "field/voxel_blocks.h"
#include "field/parallel/cpu_executor.h"

#include <gtest/gtest.h>

#include <vector>

#include "field/parallel/blocks.h"
#include "references.h"

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

/// Values of blocks at the voxels. `image`, `means`: image of the voxels and of the blocks; `difference`: a difference
/// of them that is an edge.
std::vector<std::uint8_t> interpolated(const std::vector<std::uint8_t>& blocks, const std::vector<float>& image,
                                       const std::vector<float>& means, float difference) {
  std::vector<std::uint8_t> voxels(kFine.count()), in_reverse(kFine.count());
  const auto run = [&](const RunJobs& run, std::vector<std::uint8_t>& to) {
    CpuFieldExecutor(run).each_cell(kFine, InterpolateBlocks{kFine, kBlocks.coarse, kBlocks.width, blocks.data(),
                                                             means.data(), image.data(), 1 / difference, to.data()});
  };
  run(run_serially(), voxels);
  run(run_in_reverse(), in_reverse);
  EXPECT_EQ(voxels, in_reverse);
  return voxels;
}

TEST(VoxelBlocks, CoverTheBox) {
  EXPECT_EQ(kBlocks.coarse.size, (std::array{3, 3, 6}));
  std::vector<int> block_of(kFine.count(), -1), voxels(kBlocks.coarse.count());
  kBlocks.visit(run_serially(), [&](int block, int voxel) {
    EXPECT_EQ(block_of[voxel], -1);
    block_of[voxel] = block;
    ++voxels[block];
  });
  EXPECT_EQ(block_of[(4 * 5 + 3) * 7 + 5], (4 * 3 + 1) * 3 + 1);
  EXPECT_EQ(voxels.front(), 6);
  EXPECT_EQ(voxels.back(), 1);
}

TEST(VoxelBlocks, MeanIsThatOfTheirVoxels) {
  const std::vector<float> mean = kBlocks.mean(of_index(kFine, 1, 10, 100), run_serially());
  EXPECT_FLOAT_EQ(mean[0], 1 + 5);
  EXPECT_FLOAT_EQ(mean[(2 * 3 + 1) * 3 + 1], 4 + 25 + 200);
  EXPECT_FLOAT_EQ(mean[2], 6 + 5);  // of a single column
}

TEST(VoxelBlocks, InterpolationIsLinearBetweenTheirMiddlesAndConstantBeyond) {
  std::vector<std::uint8_t> blocks;
  for (const float x : of_index(kBlocks.coarse, 30, 20, 10)) blocks.push_back(static_cast<std::uint8_t>(x));
  const std::vector<float> dark(kFine.count()), dark_blocks(blocks.size());
  const std::vector<std::uint8_t> voxels = interpolated(blocks, dark, dark_blocks, 0.1f);
  const auto at = [&](int i, int j, int k) { return voxels[(k * 5 + j) * 7 + i]; };
  EXPECT_EQ(at(0, 0, 0), 0);
  EXPECT_EQ(at(1, 0, 2), 20);
  EXPECT_EQ(at(2, 0, 0), 10);
  EXPECT_EQ(at(4, 1, 0), 30 + 5);
  EXPECT_EQ(at(6, 4, 5), 50 + 35 + 50);  // a narrow block counts like a full one
}

/// Constraint and previous field of a block, from its voxels and from balls painted over it.
TEST(VoxelBlocks, AreConstrainedByMostOfTheirVoxelsAndByBalls) {
  std::vector<Constraint> constraints(kFine.count(), Constraint::None), of_blocks(kBlocks.coarse.count());
  std::vector<std::uint8_t> before(kFine.count(), 100), mean(of_blocks.size());
  const auto set = [&](int i, int j, int k, Constraint value) { constraints[(k * 5 + j) * 7 + i] = value; };
  for (int i = 0; i < 3; ++i) set(i, 0, 1, Constraint::Outside);    // half of a block
  for (int i = 3; i < 5; ++i) set(i, 0, 1, Constraint::Outside);    // a third
  for (int i = 0; i < 3; ++i) set(i, 2, 1, Constraint::NotFinite);  // half
  set(3, 2, 1, Constraint::FarBorder);
  set(4, 2, 1, Constraint::VolumeEdge);
  set(0, 4, 1, Constraint::VolumeEdge);
  for (int i = 0; i < 3; ++i) before[35 + i] = i == 0 ? 0 : 200;
  const PaintedBall ball{
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {2, 1, 1}, 0.1, {0, 0, 0}, {2, 1, 1}, {2, 1, 1}, Constraint::Inside};
  const std::vector<int> lists = lists_of_planes({&ball, 1}, kBlocks.coarse.size[2]);
  const CpuFieldExecutor executor;
  executor.each_cell(kBlocks.coarse, ConstraintOfBlock{kFine,
                                                       kBlocks.coarse,
                                                       kBlocks.width,
                                                       {&ball, lists.data()},
                                                       constraints.data(),
                                                       before.data(),
                                                       of_blocks.data(),
                                                       mean.data()});
  const auto block = [](int i, int j) { return (1 * 3 + j) * 3 + i; };
  EXPECT_EQ(of_blocks[block(0, 0)], Constraint::Outside);
  EXPECT_EQ(of_blocks[block(1, 0)], Constraint::None);
  EXPECT_EQ(of_blocks[block(0, 1)], Constraint::NotFinite);
  EXPECT_EQ(of_blocks[block(1, 1)], Constraint::FarBorder);
  EXPECT_EQ(of_blocks[block(0, 2)], Constraint::VolumeEdge);
  EXPECT_EQ(of_blocks[block(2, 1)], Constraint::Inside);
  EXPECT_EQ(mean[block(0, 0)], 140);  // of 2 times 200 and 3 times 100, one voxel being unknown
  EXPECT_EQ(mean[block(1, 1)], 100);
}

TEST(VoxelBlocks, AVoxelGetsValuesOfBlocksOfSimilarIntensity) {
  std::vector<float> image(kFine.count());
  for (int v = 0; v < kFine.count(); ++v) image[v] = v % 7 < 4 ? 0 : 1;  // an edge within a block
  const std::vector<float> mean = kBlocks.mean(image, run_serially());
  std::vector<std::uint8_t> blocks;
  for (int b = 0; b < kBlocks.coarse.count(); ++b) blocks.push_back(b % 3 == 0 ? 0 : b % 3 == 1 ? 170 : 255);
  const std::vector<std::uint8_t> blurred = interpolated(blocks, image, mean, 100),
                                  sharp = interpolated(blocks, image, mean, 0.1f);
  EXPECT_EQ(blurred[4], 170);
  EXPECT_GT(sharp[4] - sharp[3], blurred[4] - blurred[3]);
  EXPECT_LT(sharp[2], 60);
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
  EXPECT_EQ(same.mean(values, run_serially()), values);
}

}  // namespace
}  // namespace simplexseg
