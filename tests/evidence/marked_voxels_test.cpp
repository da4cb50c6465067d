// SPDX-License-Identifier: Apache-2.0
#include "evidence/marked_voxels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace simplexseg {
namespace {

TEST(MarkedVoxels, SquaredDistancesAreToTheNearestPositionInMillimetres) {
  VolumeGeometry geometry;
  geometry.size = {9, 8, 7};
  geometry.spacing_mm = {1, 2, 3};
  const VoxelBox box{{1, 2, 0}, {7, 5, 6}};
  const std::vector<Eigen::Vector3d> places{{2, 3, 4}, {7, 9, 15}};
  const std::vector<float> squared = squared_distances(geometry, box, places, run_in_turn());
  const Eigen::Affine3d world = geometry.world_from_index();
  for (int k = 0; k < 6; ++k) {
    for (int j = 0; j < 5; ++j) {
      for (int i = 0; i < 7; ++i) {
        const Eigen::Vector3d p = world * Eigen::Vector3d(i + 1, j + 2, k);
        const double least = std::min((p - places[0]).squaredNorm(), (p - places[1]).squaredNorm());
        ASSERT_NEAR(squared[box.offset(i, j, k)], least, 1e-3);
      }
    }
  }
  EXPECT_GT(squared_distances(geometry, box, {}, run_in_turn()).front(), 1e11f);
}

/// A boundary mark constrains both sides, as far as its balls reach.
TEST(MarkedVoxels, TheBallsOfABoundaryMarkTouchAtIt) {
  VolumeGeometry geometry;
  geometry.size = {20, 20, 20};
  const VoxelBox box{{0, 0, 0}, geometry.size};
  const std::vector<Mark> marks{{MarkKind::Boundary, {10, 10, 10.5}, 1.8, {0, 0, 5}}};
  const std::vector<Constraint> known = constraint_mask(geometry, box, {}, marks, {});
  for (const int i : {9, 10, 11}) {
    EXPECT_EQ(known[box.offset(i, 10, 10)], Constraint::Inside) << i;
    EXPECT_EQ(known[box.offset(i, 10, 11)], Constraint::Outside) << i;
  }
  EXPECT_EQ(known[box.offset(10, 10, 7)], Constraint::Inside);
  EXPECT_EQ(known[box.offset(10, 10, 14)], Constraint::Outside);
  for (const int k : {6, 15}) EXPECT_EQ(known[box.offset(10, 10, k)], Constraint::None) << k;
  for (const int i : {8, 12}) EXPECT_EQ(known[box.offset(i, 10, 10)], Constraint::None) << i;
  EXPECT_TRUE(ball_offset({MarkKind::Inside, {10, 10, 10}, 1.8}).isZero());
}

}  // namespace
}  // namespace simplexseg
