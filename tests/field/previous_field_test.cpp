// SPDX-License-Identifier: Apache-2.0
#include "field/parallel/previous_field.h"
#include "field/parallel/cpu_executor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "references.h"

namespace simplexseg {
namespace {

TEST(PreviousSide, FindsTheNearestVoxelOfTheOtherSide) {
  VolumeGeometry geometry;
  geometry.size = {40, 40, 20};
  geometry.spacing_mm = {1, 1, 2.5};
  const VoxelBox box{{4, 5, 2}, {30, 28, 16}};
  std::vector<std::uint8_t> previous(box.voxel_count(), 1);
  for (int k = 4; k < 12; ++k)
    for (int j = 8; j < 20; ++j)
      for (int i = 6; i < 25; ++i) previous[box.offset(i, j, k)] = 255;
  std::vector<Eigen::Vector3d> places;
  for (const Eigen::Vector3d& index :
       {Eigen::Vector3d(15, 17, 9), Eigen::Vector3d(5, 6, 3), Eigen::Vector3d(9.6, 13, 6), Eigen::Vector3d(29, 30, 17)})
    places.push_back(geometry.world_from_index() * index);
  const CpuFieldExecutor executor(run_on_threads(2));
  const std::vector<std::uint8_t> object = previous_object(executor, geometry, box, previous.data(), places);
  const std::vector<FieldSolver::PreviousSide> at = previous_sides(executor, geometry, box, previous.data(), places);
  int inside = 0;
  for (std::size_t p = 0; p < places.size(); ++p) {
    const bool in = previous[nearest_voxel(geometry, box, places[p])] > kPreviousThreshold;
    double least = 1e12;
    each_index({box.size}, [&](int i, int j, int k, int v) {
      const Eigen::Vector3d index(box.first[0] + i, box.first[1] + j, box.first[2] + k);
      const double mm = (geometry.world_from_index() * index - places[p]).norm();
      if ((previous[v] > kPreviousThreshold) != in) least = std::min(least, mm);
    });
    EXPECT_EQ(object[p] != 0, in) << p;
    EXPECT_EQ(at[p].object, in) << p;
    EXPECT_NEAR(at[p].depth_mm, least, 1e-3) << p;
    inside += in;
  }
  EXPECT_EQ(inside, 2);
}

}  // namespace
}  // namespace simplexseg
