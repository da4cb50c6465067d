// SPDX-License-Identifier: Apache-2.0
#include "field/parallel/constraints.h"
#include "field/parallel/cpu_executor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "references.h"

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

/// Marks of all kinds at voxel centres and elsewhere, overlapping and beyond the box. No voxel lies on a surface.
std::vector<Mark> marks_in(const VolumeGeometry& geometry) {
  const Eigen::Affine3d mm = geometry.world_from_index();
  return {{MarkKind::Inside, mm * Eigen::Vector3d(12, 12, 10), 2.1517, {0, 0, 0}},
          {MarkKind::Outside, mm * Eigen::Vector3d(14.5, 12.2, 10), 1.8313, {0, 0, 0}},
          {MarkKind::Boundary, mm * Eigen::Vector3d(8, 12, 10), 2.8371, {1, 0.5, 0.2}},
          {MarkKind::Inside, mm * Eigen::Vector3d(3.4, 3.6, 3.3), 0.01, {0, 0, 0}},
          {MarkKind::Inside, mm * Eigen::Vector3d(25, 20, 18), 6.0513, {0, 0, 0}}};
}

std::vector<Constraint> reference(const VolumeGeometry& geometry, const VoxelBox& box,
                                  const std::vector<std::uint8_t>& finite, std::span<const Mark> marks,
                                  std::span<const Mark> others) {
  std::vector<Constraint> constraints(box.voxel_count(), Constraint::None);
  each_index({box.size}, [&](int i, int j, int k, int v) {
    const int at[3]{i, j, k};
    for (int a = 0; a < 3; ++a) {
      const bool low = at[a] == 0, high = at[a] + 1 == box.size[a];
      if (box.size[a] == 1 || !(low || high)) continue;
      const int index = box.first[a] + at[a];
      const bool edge = low ? index == 0 : index + 1 == geometry.size[a];
      if (!edge) constraints[v] = Constraint::FarBorder;
      if (edge && constraints[v] == Constraint::None) constraints[v] = Constraint::VolumeEdge;
    }
    if (!finite.empty() && !finite[v]) constraints[v] = Constraint::NotFinite;
  });
  for (const Mark& other : others)
    paint_ball(constraints, geometry, box, other.position_mm, other.radius_mm, Constraint::OtherObject);
  paint_marks(constraints, geometry, box, marks);
  return constraints;
}

TEST(Constraints, AreThoseOfTheLastBallOrOfTheSideOfTheBox) {
  for (const bool sheared : {false, true}) {
    const VolumeGeometry geometry = geometry_of(sheared);
    const std::vector<Mark> marks = marks_in(geometry);
    for (const VoxelBox& box : {VoxelBox{{0, 0, 0}, geometry.size}, VoxelBox{{2, 0, 3}, {24, 26, 12}},
                                VoxelBox{{2, 1, 10}, {24, 20, 1}}, VoxelBox{{13, 1, 2}, {17, 25, 19}}}) {
      const int n = static_cast<int>(box.voxel_count());
      std::vector<std::uint8_t> finite(n, 1);
      for (int v = 0; v < n; v += 7) finite[v] = 0;
      const Eigen::Affine3d mm = geometry.world_from_index();
      const std::vector<Mark> others{{MarkKind::Inside, mm * Eigen::Vector3d(18, 14, 10), 3.0519, {0, 0, 0}}};
      const CpuFieldExecutor executor;
      ConstraintMask<CpuFieldExecutor> found(executor);
      std::vector<Constraint> constraints(n);
      found.find(geometry, box, finite.data(), nullptr, marks, others, constraints.data());
      EXPECT_EQ(constraints, reference(geometry, box, finite, marks, others));
      EXPECT_EQ(constraint_mask(geometry, box, finite, marks, others), constraints);
      for (const Constraint kind :
           {Constraint::Inside, Constraint::Outside, Constraint::OtherObject, Constraint::NotFinite})
        EXPECT_GT(std::count(constraints.begin(), constraints.end(), kind), 3);
      found.find(geometry, box, nullptr, nullptr, std::span(marks).first(1), {}, constraints.data());
      EXPECT_EQ(constraints, reference(geometry, box, {}, std::span(marks).first(1), {}));
      EXPECT_EQ(constraint_mask(geometry, box, {}, std::span(marks).first(1), {}), constraints);
    }
  }
}

TEST(Constraints, VoxelsOutOfRangeYieldToMarksAndToSidesOfTheBox) {
  const VolumeGeometry geometry = geometry_of(false);
  const VoxelBox box{{2, 0, 3}, {24, 26, 12}};
  const std::vector<Mark> marks = marks_in(geometry);
  const std::vector<std::uint8_t> none(box.voxel_count(), 0);
  const std::vector<Constraint> in_range = constraint_mask(geometry, box, {}, marks, {}),
                                out_of_range = constraint_mask(geometry, box, {}, marks, {}, none);
  for (std::size_t v = 0; v < in_range.size(); ++v)
    EXPECT_EQ(out_of_range[v], in_range[v] == Constraint::None ? Constraint::OutOfRange : in_range[v]) << v;
  EXPECT_TRUE(is_excluded(Constraint::OutOfRange));
  EXPECT_FALSE(is_excluded_by_mark(Constraint::OutOfRange)) << "holes of single voxels are filled";
}

TEST(Constraints, TheNearestVoxelOfASmallBallBelongsToIt) {
  const VolumeGeometry geometry = geometry_of(false);
  const std::vector<Mark> marks = marks_in(geometry);
  const std::vector<Constraint> constraints =
      constraint_mask(geometry, {{0, 0, 0}, geometry.size}, {}, std::span(marks).subspan(3, 1), {});
  EXPECT_EQ(std::count(constraints.begin(), constraints.end(), Constraint::Inside), 1);
  EXPECT_EQ(constraints[(3 * 26 + 4) * 30 + 3], Constraint::Inside);
}

}  // namespace
}  // namespace simplexseg
