// SPDX-License-Identifier: Apache-2.0
#include "evidence/parallel/constraints.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace simplexseg {
namespace {

VolumeGeometry geometry_of(bool sheared) {
  VolumeGeometry geometry;
  geometry.size = {30, 26, 22};
  geometry.spacing_mm = {0.7, 0.9, 1.3};
  geometry.origin_mm = {-5, 3, 8};
  if (sheared) geometry.direction << 1, 0.2, 0.1, 0, 1, 0.1, 0.1, 0, 1;
  return geometry;
}

/// Marks of all kinds at voxel centres and elsewhere, overlapping and beyond the box.
std::vector<Mark> marks_in(const VolumeGeometry& geometry) {
  const Eigen::Affine3d mm = geometry.world_from_index();
  return {{MarkKind::Inside, mm * Eigen::Vector3d(12, 12, 10), 2.1, {0, 0, 0}},
          {MarkKind::Outside, mm * Eigen::Vector3d(14.5, 12.2, 10), 1.8, {0, 0, 0}},
          {MarkKind::Boundary, mm * Eigen::Vector3d(8, 12, 10), 2.8, {1, 0.5, 0.2}},
          {MarkKind::Inside, mm * Eigen::Vector3d(3.5, 3.5, 3.5), 0.01, {0, 0, 0}},
          {MarkKind::Inside, mm * Eigen::Vector3d(25, 20, 18), 6, {0, 0, 0}}};
}

TEST(ParallelConstraints, EqualThoseOfTheCpu) {
  for (const bool sheared : {false, true}) {
    const VolumeGeometry geometry = geometry_of(sheared);
    const std::vector<Mark> marks = marks_in(geometry);
    for (const VoxelBox& box :
         {VoxelBox{{0, 0, 0}, geometry.size}, VoxelBox{{2, 0, 3}, {24, 26, 12}}, VoxelBox{{2, 1, 10}, {24, 20, 1}}}) {
      const int n = static_cast<int>(box.voxel_count());
      std::vector<std::uint8_t> finite(n, 1);
      for (int v = 0; v < n; v += 7) finite[v] = 0;
      const Eigen::Affine3d mm = geometry.world_from_index();
      const std::vector<Mark> others{{MarkKind::Inside, mm * Eigen::Vector3d(18, 14, 10), 3, {0, 0, 0}}};
      const SerialExecutor executor;
      ConstraintVoxels<SerialExecutor> found(executor);
      std::vector<Constraint> known(n);
      found.find(geometry, box, finite.data(), marks, others, known.data());
      EXPECT_EQ(known, constraint_mask(geometry, box, finite, marks, others));
      for (const Constraint kind :
           {Constraint::Inside, Constraint::Outside, Constraint::OtherObject, Constraint::NotFinite})
        EXPECT_GT(std::count(known.begin(), known.end(), kind), 3);
      found.find(geometry, box, nullptr, std::span(marks).first(1), {}, known.data());
      EXPECT_EQ(known, constraint_mask(geometry, box, {}, std::span(marks).first(1), {}));
    }
  }
}

}  // namespace
}  // namespace simplexseg
