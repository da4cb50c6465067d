// SPDX-License-Identifier: Apache-2.0
#include "image/cell_grid.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace simplexseg {
namespace {

VolumeGeometry oblique() {
  VolumeGeometry geometry;
  geometry.size = {41, 30, 17};
  geometry.spacing_mm = {0.7, 0.8, 2};
  geometry.origin_mm = {12, -3, 40};
  geometry.direction << 0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, -1;
  return geometry;
}

TEST(CellGrid, VoxelCellsAreTheVolume) {
  const VolumeGeometry geometry = oblique();
  EXPECT_EQ(cell_geometry(geometry, kVoxelCells).world_from_index().matrix(), geometry.world_from_index().matrix());
  const VoxelBox box{{3, 4, 5}, {6, 7, 8}};
  EXPECT_EQ(cells_around(box, kVoxelCells, geometry.size), box);
  EXPECT_EQ(voxels_around(box, kVoxelCells, geometry.size), box);
}

TEST(CellGrid, CellsBeginAtTheCornerOfTheVolume) {
  const VolumeGeometry geometry = oblique();
  const CellSize cell{2.5, 2, 1};
  const VolumeGeometry cells = cell_geometry(geometry, cell);
  EXPECT_EQ(cells.size, (std::array{17, 15, 17}));
  const Eigen::Vector3d corner(-0.5, -0.5, -0.5);
  EXPECT_LT((cells.world_from_index() * corner - geometry.world_from_index() * corner).norm(), 1e-12);
  const VoxelToCell to_cell(cell);
  for (const Eigen::Vector3d& voxel : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(7, 11, 3)}) {
    const Eigen::Vector3d index(to_cell(0, voxel[0]), to_cell(1, voxel[1]), to_cell(2, voxel[2]));
    EXPECT_LT((cells.world_from_index() * index - geometry.world_from_index() * voxel).norm(), 1e-12);
  }
}

TEST(CellGrid, BoxesContainEachOther) {
  const std::array<int, 3> size{41, 30, 17};
  for (const CellSize& cell : {CellSize{1.4142135, 1.4142135, 1}, CellSize{3, 2.5, 1.2}, CellSize{50, 50, 50}}) {
    for (int first = 0; first < 16; ++first) {
      const VoxelBox voxels{{first, first, first}, {41 - first, 9, 1}};
      const VoxelBox cells = cells_around(voxels, cell, size), back = voxels_around(cells, cell, size);
      EXPECT_TRUE(cells.lies_in(cell_geometry({size}, cell).size));
      EXPECT_TRUE(back.lies_in(size));
      for (int a = 0; a < 3; ++a) {
        EXPECT_LE(back.first[a], voxels.first[a]);
        EXPECT_GE(back.first[a] + back.size[a], voxels.first[a] + voxels.size[a]);
      }
    }
  }
}

TEST(CellGrid, MaskFollowsTheInterpolantBetweenCells) {
  VolumeGeometry volume;
  volume.size = {16, 6, 4};
  // Values rise along i; they pass 500 halfway between the centres of cells 1 and 2 (voxel 5.5 of cells of 3 voxels).
  const VoxelBox box{{0, 0, 0}, {5, 2, 2}};
  std::vector<std::uint16_t> values(box.voxel_count());
  for (std::size_t v = 0; v < values.size(); ++v) values[v] = v % 5 < 2 ? 400 : 600;
  const Mask mask = mask_above(volume, {3, 3, 2}, box, values, 500);
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
    const auto i = static_cast<int>(v % 16);
    EXPECT_EQ(mask.voxels[v], i >= 6 && i < 15) << i;  // voxel 15 lies outside the box
  }
}

}  // namespace
}  // namespace simplexseg
