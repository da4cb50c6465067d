// SPDX-License-Identifier: Apache-2.0
#include "field/marked_voxels.h"

#include <gtest/gtest.h>

#include <vector>

namespace simplexseg {
namespace {

/// A boundary mark constrains both sides, as far as its balls reach.
TEST(MarkedVoxels, TheBallsOfABoundaryMarkTouchAtIt) {
  VolumeGeometry geometry;
  geometry.size = {20, 20, 20};
  const VoxelBox box{{0, 0, 0}, geometry.size};
  const std::vector<Mark> marks{{MarkKind::Boundary, {10, 10, 10.5}, 1.8, {0, 0, 5}}};
  const std::vector<Constraint> constraints = constraint_mask(geometry, box, {}, marks, {});
  for (const int i : {9, 10, 11}) {
    EXPECT_EQ(constraints[box.offset(i, 10, 10)], Constraint::Inside) << i;
    EXPECT_EQ(constraints[box.offset(i, 10, 11)], Constraint::Outside) << i;
  }
  EXPECT_EQ(constraints[box.offset(10, 10, 7)], Constraint::Inside);
  EXPECT_EQ(constraints[box.offset(10, 10, 14)], Constraint::Outside);
  for (const int k : {6, 15}) EXPECT_EQ(constraints[box.offset(10, 10, k)], Constraint::None) << k;
  for (const int i : {8, 12}) EXPECT_EQ(constraints[box.offset(i, 10, 10)], Constraint::None) << i;
  EXPECT_TRUE(ball_offset({MarkKind::Inside, {10, 10, 10}, 1.8}).isZero());
}

}  // namespace
}  // namespace simplexseg
