// SPDX-License-Identifier: Apache-2.0
#include "field/box_prompt.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "field/robot_stroke.h"
#include "field/stroke.h"
#include "image/volume.h"

namespace simplexseg {
namespace {

VolumeGeometry volume_of(std::array<int, 3> size) {
  VolumeGeometry volume;
  volume.size = size;
  volume.spacing_mm = {1, 1, 2};
  return volume;
}
BoxCorners rectangle(double x0, double x1, double y0, double y1, double z) {
  return {Eigen::Vector3d(x0, y0, z), {x1, y0, z}, {x1, y1, z}, {x0, y1, z}};
}

std::vector<std::vector<Eigen::Vector3d>> paths(const BoxPrompt& prompt, MarkKind kind) {
  std::vector<std::vector<Eigen::Vector3d>> paths;
  for (const PromptStroke& stroke : prompt.strokes)
    if (stroke.kind == kind) paths.push_back(stroke.path_mm);
  return paths;
}

TEST(BoxPrompt, HasASeedInItsCentreAndSurroundsTheBox) {
  const BoxPrompt prompt = prompt_of_box(rectangle(20, 60, 30, 50, 20), volume_of({100, 100, 40}));
  EXPECT_EQ(prompt.seed.position_mm, Eigen::Vector3d(40, 40, 20));
  EXPECT_DOUBLE_EQ(prompt.seed.radius_mm, 3.5);
  ASSERT_EQ(paths(prompt, MarkKind::Inside).size(), 1u);
  const std::vector<Eigen::Vector3d> inside = paths(prompt, MarkKind::Inside)[0];
  ASSERT_EQ(inside.size(), 2u);
  EXPECT_LT((inside[1] - Eigen::Vector3d(43.5, 40, 20)).norm(), 1e-9);
  ASSERT_EQ(paths(prompt, MarkKind::Outside).size(), 1u);
  const std::vector<Eigen::Vector3d> path = paths(prompt, MarkKind::Outside)[0];
  ASSERT_EQ(path.size(), 5u);
  EXPECT_LT((path[0] - Eigen::Vector3d(15, 25, 20)).norm(), 1e-9);
  EXPECT_LT((path[2] - Eigen::Vector3d(65, 55, 20)).norm(), 1e-9);
  EXPECT_EQ(path[4], path[0]) << "closed";
  const std::vector<Mark> marks = prompt.marks();
  EXPECT_EQ(prompt_count(marks), 3);
  for (std::size_t m = 1; m < marks.size(); ++m) EXPECT_NE(marks[m].link, MarkLink::None) << "one update";
}

TEST(BoxPrompt, OfASquareHasNoStrokeInside) {
  EXPECT_TRUE(paths(prompt_of_box(rectangle(20, 50, 30, 60, 20), volume_of({100, 100, 40})), MarkKind::Inside).empty());
}

TEST(BoxPrompt, LeavesOutSidesBeyondTheVolume) {
  const VolumeGeometry volume = volume_of({100, 100, 40});
  const auto left = paths(prompt_of_box(rectangle(2, 40, 30, 60, 20), volume), MarkKind::Outside);
  ASSERT_EQ(left.size(), 1u) << "the three other sides are one stroke";
  EXPECT_EQ(left[0].size(), 4u);
  for (const Eigen::Vector3d& vertex : left[0]) EXPECT_TRUE(volume.contains(vertex));
  const auto both = paths(prompt_of_box(rectangle(2, 98, 30, 60, 20), volume), MarkKind::Outside);
  EXPECT_EQ(both.size(), 2u) << "above and below";
  EXPECT_TRUE(paths(prompt_of_box(rectangle(-1, 100, -1, 100, 20), volume), MarkKind::Outside).empty());
}

/// In a volume that is turned, the corners of a side may lie outside and its middle inside.
TEST(BoxPrompt, NoStrokeEntersTheBoxInATurnedVolume) {
  VolumeGeometry volume;
  volume.size = {101, 101, 3};
  volume.direction = Eigen::AngleAxisd(M_PI / 4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  volume.origin_mm = -(volume.direction * Eigen::Vector3d(50, 50, 1));
  const auto outside = paths(prompt_of_box(rectangle(-40, 40, -40, 60, 0), volume), MarkKind::Outside);
  EXPECT_FALSE(outside.empty());
  for (const std::vector<Eigen::Vector3d>& path : outside)
    for (const Eigen::Vector3d& vertex : path) {
      EXPECT_TRUE(volume.contains(vertex)) << vertex.transpose();
      EXPECT_TRUE(std::abs(vertex.x()) > 44.9 || std::abs(vertex.y() - 10) > 54.9) << vertex.transpose();
    }
}

TEST(BoxPrompt, RefusesABoxWithoutSizeOrBesideTheVolume) {
  const VolumeGeometry volume = volume_of({100, 100, 40});
  EXPECT_THROW(prompt_of_box(rectangle(20, 20, 30, 50, 20), volume), Error);
  EXPECT_THROW(prompt_of_box(rectangle(20, NAN, 30, 50, 20), volume), Error);
  EXPECT_THROW(prompt_of_box(rectangle(120, 160, 30, 50, 20), volume), Error);
}

TEST(RobotBox, SurroundsTheLargestSliceWithinAVoxel) {
  Mask object{volume_of({60, 50, 12}), {}};
  object.voxels.assign(object.geometry.voxel_count(), 0);
  for (int k = 4; k < 8; ++k)
    for (int j = 10; j < 30; ++j)
      for (int i = 20; i < 50; ++i) object.voxels[(std::size_t(k) * 50 + j) * 60 + i] = 1;
  const BoxCorners corners = box_around_object(object, *deepest_voxel(object));
  const Eigen::Vector3d expected[]{{19.5, 9.5, 0}, {49.5, 9.5, 0}, {49.5, 29.5, 0}, {19.5, 29.5, 0}};
  for (int c = 0; c < 4; ++c) {
    EXPECT_NEAR(corners[c].x(), expected[c].x(), 1) << c;
    EXPECT_NEAR(corners[c].y(), expected[c].y(), 1) << c;
    EXPECT_EQ(corners[c].z(), corners[0].z());
  }
}

}  // namespace
}  // namespace simplexseg
