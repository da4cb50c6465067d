// SPDX-License-Identifier: Apache-2.0
#include "field/stroke.h"

#include <gtest/gtest.h>

#include "field/evidence_field.h"
#include "field/robot_stroke.h"
#include "image/paint_stroke.h"
#include "support/empty_mask.h"

namespace simplexseg {
namespace {

Eigen::Vector3d at(double x, double y = 0, double z = 0) { return {x, y, z}; }

TEST(Stroke, BallsLieOnThePathAtMostARadiusApartAndIncludeItsEnds) {
  const std::vector<Eigen::Vector3d> path{at(0), at(10), at(10, 0.1), at(10, 7.3)};
  const std::vector<Mark> marks = marks_of_stroke(MarkKind::Outside, path, 2);
  ASSERT_GE(marks.size(), 10u);
  EXPECT_EQ(marks.front().position_mm, path.front());
  EXPECT_LT((marks.back().position_mm - path.back()).norm(), 1e-9);
  for (std::size_t m = 0; m < marks.size(); ++m) {
    EXPECT_EQ(marks[m].kind, MarkKind::Outside);
    EXPECT_EQ(marks[m].radius_mm, 2);
    EXPECT_EQ(marks[m].link, m > 0 ? MarkLink::Stroke : MarkLink::None);
    const Eigen::Vector3d& p = marks[m].position_mm;
    EXPECT_TRUE(std::abs(p.y()) < 1e-9 || std::abs(p.x() - 10) < 1e-9) << p.transpose();
    if (m > 0) {
      EXPECT_LE((p - marks[m - 1].position_mm).norm(), 2 + 1e-9);
    }
  }
}

TEST(Stroke, APathWithoutLengthIsOneBall) {
  EXPECT_EQ(marks_of_stroke(MarkKind::Inside, std::vector{at(3)}, 1).size(), 1u);
  EXPECT_EQ(marks_of_stroke(MarkKind::Inside, std::vector{at(3), at(3)}, 1).size(), 1u);
}

TEST(Stroke, IsOnePrompt) {
  std::vector<Mark> marks{{MarkKind::Inside, at(0), 3}, {MarkKind::Boundary, at(3), 1, at(1)}};
  const std::vector<Mark> stroke = marks_of_stroke(MarkKind::Inside, std::vector{at(0), at(9)}, 1);
  marks.insert(marks.end(), stroke.begin(), stroke.end());
  EXPECT_EQ(prompt_count(marks), 3);
  EXPECT_EQ(prompt_ball_count(marks), 4);
}

/// Image of two parallel bars: the object, and one of the same intensity.
Volume two_bars() {
  VolumeGeometry geometry;
  geometry.size = {48, 32, 20};
  Volume image(geometry, VoxelType::Float32);
  const std::span<float> voxels = image.voxels<float>();
  for (int k = 0; k < 20; ++k)
    for (int j = 0; j < 32; ++j)
      for (int i = 0; i < 48; ++i) {
        const bool bar = i > 7 && i < 40 && k > 6 && k < 13 && ((j > 7 && j < 14) || (j > 17 && j < 24));
        voxels[(std::size_t(k) * 32 + j) * 48 + i] =
            (bar ? 100.0f : 0.0f) + static_cast<float>((i * 7 + j * 5 + k) % 9);
      }
  return image;
}

TEST(Stroke, FixesEveryVoxelOnItsPath) {
  const Volume image = two_bars();
  EvidenceField field(image);
  std::vector<Mark> marks{{MarkKind::Inside, at(24, 10.5, 9.5), 3}};
  field.update(marks);
  const std::vector<Mark> stroke =
      marks_of_stroke(MarkKind::Outside, std::vector{at(9, 10.5, 9.5), at(16, 10.5, 9.5)}, 1.5);
  marks.insert(marks.end(), stroke.begin(), stroke.end());
  field.update(marks);
  const Mask object = field.object();
  const auto voxel = [&](int i) { return object.voxels[(std::size_t(9) * 32 + 10) * 48 + i]; };
  for (int i = 9; i <= 16; ++i) EXPECT_EQ(voxel(i), 0) << i;
  EXPECT_EQ(voxel(24), 1);
  EXPECT_EQ(voxel(36), 1) << "the other end is not marked";
}

TEST(RobotStroke, FollowsTheMiddleOfAnErrorInTheSliceThatShowsMostOfIt) {
  // A flat, bent error in a slice k = 5: two arms of 5 voxels width.
  Mask truth = empty_mask({40, 40, 12}, {1, 1, 2});
  const Mask now = truth;
  for (int n = 4; n < 36; ++n)
    for (int w = -2; w <= 2; ++w) {
      truth.voxels[(std::size_t(5) * 40 + (6 + w)) * 40 + n] = 1;
      truth.voxels[(std::size_t(5) * 40 + n) * 40 + (6 + w)] = 1;
    }
  const WorstError error = *worst_error(truth, now);
  const std::vector<Eigen::Vector3d> path = stroke_in_error(truth, now, error, 1);
  ASSERT_GE(path.size(), 8u);
  double length = 0;
  for (std::size_t p = 0; p < path.size(); ++p) {
    EXPECT_EQ(path[p].z(), 10) << "the slice k = 5";
    EXPECT_TRUE(std::abs(path[p].x() - 6) <= 2 || std::abs(path[p].y() - 6) <= 2) << path[p].transpose();
    if (p > 0) length += (path[p] - path[p - 1]).norm();
  }
  EXPECT_GT(length, 45) << "from one end to the other";
  EXPECT_EQ(stroke_in_error(truth, now, error, 1), path);
  EXPECT_NE(stroke_in_error(truth, now, error, 2), path) << "another noise";
}

TEST(RobotStroke, OfASingleVoxelStaysNearIt) {
  Mask truth = empty_mask({9, 9, 9});
  truth.voxels[(std::size_t(4) * 9 + 4) * 9 + 4] = 1;
  const std::vector<Eigen::Vector3d> path = stroke_in_error(truth, empty_mask({9, 9, 9}), {{4, 4, 4}, 1, 1, true}, 3);
  ASSERT_EQ(path.size(), 1u);
  EXPECT_LT((path[0] - at(4, 4, 4)).norm(), 0.8);
}

TEST(RobotLasso, SurroundsTheObjectOrWhatIsSurplus) {
  Mask truth = empty_mask({48, 48, 12}, {1, 1, 2});
  Mask now = truth;
  const auto fill = [](Mask& mask, int i0, int i1, int j0, int j1) {
    for (int k = 4; k < 7; ++k)
      for (int j = j0; j < j1; ++j)
        for (int i = i0; i < i1; ++i) mask.voxels[(std::size_t(k) * 48 + j) * 48 + i] = 1;
  };
  fill(truth, 10, 38, 10, 38);
  fill(now, 10, 30, 10, 38);
  // The robot draws around the whole object, not around the missing part alone.
  RobotLasso lasso = *lasso_at_error(truth, now, *worst_error(truth, now), 1);
  EXPECT_EQ(lasso.kind, MarkKind::Inside);
  EXPECT_LT((lasso.normal.cwiseAbs() - Eigen::Vector3d(0, 0, 1)).norm(), 1e-9);
  for (const Eigen::Vector3d& at : lasso.contour_mm) {
    const double left = std::abs(at.x() - 9.5), right = std::abs(at.x() - 37.5), low = std::abs(at.y() - 9.5),
                 high = std::abs(at.y() - 37.5);
    EXPECT_LE(std::min({left, right, low, high}), 0.51) << at.transpose();
  }
  PaintStroke paint{true, lasso.contour_mm, 0, PaintBrush::contour(lasso.normal, 2)};
  Mask enclosed = empty_mask({48, 48, 12}, {1, 1, 2});
  apply(paint, enclosed);
  EXPECT_NEAR(static_cast<double>(std::ranges::count(enclosed.voxels, 1)), 28 * 28, 40);
  EXPECT_EQ(lasso_at_error(truth, now, *worst_error(truth, now), 1)->contour_mm, lasso.contour_mm);
  now = truth;
  fill(now, 38, 45, 16, 30);
  lasso = *lasso_at_error(truth, now, *worst_error(truth, now), 1);
  EXPECT_EQ(lasso.kind, MarkKind::Outside);
  for (const Eigen::Vector3d& at : lasso.contour_mm) EXPECT_GT(at.x(), 36.9);
  now = truth;
  now.voxels[(std::size_t(5) * 48 + 20) * 48 + 44] = 1;
  EXPECT_FALSE(lasso_at_error(truth, now, *worst_error(truth, now), 1)) << "one voxel is too small";
}

}  // namespace
}  // namespace simplexseg
