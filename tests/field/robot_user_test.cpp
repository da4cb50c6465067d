// SPDX-License-Identifier: Apache-2.0
#include "field/robot_user.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "support/empty_mask.h"

namespace simplexseg {
namespace {

void fill(Mask& mask, std::array<int, 3> first, std::array<int, 3> last) {
  const auto& size = mask.geometry.size;
  for (int k = first[2]; k <= last[2]; ++k)
    for (int j = first[1]; j <= last[1]; ++j)
      for (int i = first[0]; i <= last[0]; ++i) mask.voxels[(std::size_t(k) * size[1] + j) * size[0] + i] = 1;
}

TEST(RobotUser, ClicksIntoTheMiddleOfTheLargestError) {
  Mask truth = empty_mask({20, 20, 20}), now = truth;
  EXPECT_FALSE(worst_error(truth, now));
  fill(truth, {2, 2, 2}, {6, 6, 6});
  fill(now, {12, 12, 12}, {14, 14, 14});
  const WorstError missing = *worst_error(truth, now);
  EXPECT_TRUE(missing.too_little);
  EXPECT_EQ(missing.voxel, (std::array{4, 4, 4}));
  EXPECT_EQ(missing.voxels, 125u);
  EXPECT_DOUBLE_EQ(missing.depth_mm, 3);
  fill(now, {10, 10, 10}, {16, 16, 16});
  const WorstError extra = *worst_error(truth, now);
  EXPECT_FALSE(extra.too_little);
  EXPECT_EQ(extra.voxel, (std::array{13, 13, 13}));
}

TEST(RobotUser, DepthIsInMillimetres) {
  Mask mask = empty_mask({20, 20, 9}, {1, 1, 5});
  fill(mask, {3, 3, 3}, {13, 13, 5});
  const WorstError deepest = *deepest_voxel(mask);
  EXPECT_EQ(deepest.voxel, (std::array{8, 8, 4}));
  EXPECT_DOUBLE_EQ(deepest.depth_mm, 6);
}

TEST(RobotUser, SeparatesPartsThatShareNoFace) {
  Mask mask = empty_mask({10, 10, 10});
  fill(mask, {0, 0, 0}, {2, 2, 2});
  fill(mask, {3, 3, 3}, {6, 6, 6});  // touches the first only at a corner
  const Mask part = largest_part(mask);
  EXPECT_EQ(std::count(part.voxels.begin(), part.voxels.end(), 1), 64);
}

TEST(RobotUser, ReachOfAClickCountsChangesFartherThanThreeDepths) {
  Mask before = empty_mask({30, 10, 10}, {1, 1, 4}), after = before;
  fill(before, {2, 2, 2}, {4, 4, 4});  // stays
  fill(after, {2, 2, 2}, {4, 4, 4});
  fill(after, {10, 5, 5}, {16, 5, 5});   // the click is at the first of these, and three depths are 6 mm
  fill(before, {10, 5, 7}, {10, 5, 7});  // removed, 8 mm away
  const ClickReach reach = reach_of_click(before, after, {10, 5, 5}, 2, 50);
  EXPECT_EQ(reach.depth_mm, 2);
  EXPECT_DOUBLE_EQ(reach.far_share, 1.0 / 50) << "what is exactly three depths away is near";
  EXPECT_DOUBLE_EQ(reach.farthest_mm, 8);
  const ClickReach near = reach_of_click(before, after, {10, 5, 5}, 2.7, 50);
  EXPECT_EQ(near.far_share, 0);
  EXPECT_EQ(reach_of_click(after, after, {10, 5, 5}, 2, 50).farthest_mm, 0);
  EXPECT_THROW(reach_of_click(empty_mask({5, 5, 5}), after, {1, 1, 1}, 2, 50), Error);
}

/// Segments exactly the marked balls.
class MarkedBalls : public RobotSubject {
 public:
  std::vector<std::vector<Mark>> received;

  Mask segment(std::span<const Mark> marks) override {
    received.emplace_back(marks.begin(), marks.end());
    Mask mask = empty_mask({30, 30, 30});
    std::size_t v = 0;
    for (int k = 0; k < 30; ++k)
      for (int j = 0; j < 30; ++j)
        for (int i = 0; i < 30; ++i, ++v)
          for (const Mark& m : marks)
            if ((Eigen::Vector3d(i, j, k) - m.position_mm).norm() <= m.radius_mm)
              mask.voxels[v] = m.kind == MarkKind::Inside;
    return mask;
  }
  double brush_mm(MarkKind, const Eigen::Vector3d&) const override { return 2.5; }
};

TEST(RobotUser, FollowsTheProtocol) {
  Mask truth = empty_mask({30, 30, 30});
  fill(truth, {8, 8, 8}, {20, 20, 20});
  MarkedBalls subject;
  int calls = 0;
  const std::vector<RobotClick> clicks =
      run_robot(truth, subject, {5, 1, 0}, [&](int n, const Mask&) { EXPECT_EQ(n, calls++); });
  ASSERT_EQ(clicks.size(), 6u);
  EXPECT_EQ(calls, 6);
  EXPECT_EQ(clicks[0].mark.position_mm, Eigen::Vector3d(14, 14, 14));
  EXPECT_NEAR(clicks[0].mark.radius_mm, 7, 0.01);
  for (std::size_t c = 1; c < clicks.size(); ++c) {
    EXPECT_EQ(subject.received[c].size(), c + 1);
    EXPECT_EQ(clicks[c].mark.radius_mm, 2.5);
    EXPECT_GT(clicks[c].agreement.dice, clicks[c - 1].agreement.dice);
    EXPECT_GE(clicks[c].reach.depth_mm, 1);
    EXPECT_GE(clicks[c].reach.farthest_mm, 2) << "a ball of 2.5 voxels was added";
    EXPECT_LE(clicks[c].reach.farthest_mm, 2.5);
    EXPECT_EQ(clicks[c].reach.far_share, 0);
  }
  EXPECT_EQ(clicks[0].reach.depth_mm, 0) << "the seed corrects nothing";
  const RobotClick small = run_robot(truth, subject, {0, 0.5, 0.25}, [](int, const Mask&) {}).front();
  EXPECT_NEAR(small.mark.radius_mm, 3.5, 0.01);
  EXPECT_NEAR((small.mark.position_mm - Eigen::Vector3d(14, 14, 14)).norm(), 1.75, 0.01);
  EXPECT_THROW(run_robot(empty_mask({5, 5, 5}), subject, {}, [](int, const Mask&) {}), Error);
}

}  // namespace
}  // namespace simplexseg
