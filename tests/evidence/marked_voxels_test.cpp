// SPDX-License-Identifier: Apache-2.0
#include "evidence/marked_voxels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace simplexseg {
namespace {

TEST(MarkedVoxels, SquaredDistancesAreThoseToTheNearestPlaceInMillimetres) {
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

}  // namespace
}  // namespace simplexseg
