// SPDX-License-Identifier: Apache-2.0
#include "field/lasso_prompt.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "ellipsoid_scene.h"
#include "field/field_subject.h"
#include "image/plane_contour.h"
#include "image/volume.h"

namespace simplexseg {
namespace {

VolumeGeometry cube_of(int size) {
  VolumeGeometry volume;
  volume.size = {size, size, size};
  return volume;
}
/// Closed contour of `lobes` lobes about a centre; 0: a circle.
std::vector<Eigen::Vector3d> lobed(const Eigen::Vector3d& centre, double radius, int lobes, int vertices = 90) {
  std::vector<Eigen::Vector3d> contour;
  for (int n = 0; n < vertices; ++n) {
    const double angle = 2 * std::numbers::pi * n / vertices,
                 r = radius * (lobes ? 1 + 0.4 * std::cos(lobes * angle) : 1);
    contour.emplace_back(centre + Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), 0));
  }
  return contour;
}

TEST(LassoPrompt, ContourIsNearerThanItsDistance) {
  for (const int vertices : {3, 10, 400}) {
    const PlaneContour plane(lobed({50, 50, 20}, 25, 3, vertices), {0.6, 0, 0.8});
    for (int n = 0; n < 400; ++n) {
      const Eigen::Vector3d at(n % 20 * 5, n / 20 * 5, 20);
      const double distance = plane.distance_mm(at);
      EXPECT_FALSE(plane.is_nearer_than(distance, at));
      EXPECT_TRUE(plane.is_nearer_than(1.0001 * distance + 1e-9, at));
      EXPECT_FALSE(plane.is_nearer_than(0.5 * distance, at));
    }
  }
}

TEST(LassoPrompt, LiesOnItsSideOfTheContour) {
  for (const int lobes : {0, 3, 5}) {
    const auto contour = lobed({50, 50, 20}, 25, lobes);
    const PlaneContour plane(contour, {0, 0, 1});
    double inside_mm = 0, outside_mm = 0;
    for (const PromptStroke& stroke : prompt_of_lasso(MarkKind::Inside, contour, {0, 0, 1}, cube_of(100))) {
      for (std::size_t p = 0; p < stroke.path_mm.size(); ++p) {
        const Eigen::Vector3d& at = stroke.path_mm[p];
        EXPECT_EQ(plane.encloses(at), stroke.kind == MarkKind::Inside) << lobes;
        EXPECT_GT(plane.distance_mm(at), 0.9 * stroke.radius_mm) << "balls do not cross the contour";
        EXPECT_NEAR(at.z(), 20, 1e-9);
        if (p == 0) continue;
        const double step = (at - stroke.path_mm[p - 1]).norm();
        EXPECT_EQ(plane.encloses((at + stroke.path_mm[p - 1]) / 2), stroke.kind == MarkKind::Inside);
        (stroke.kind == MarkKind::Inside ? inside_mm : outside_mm) += step;
      }
    }
    EXPECT_GT(outside_mm, 2 * std::numbers::pi * 25 * 0.8) << "nearly closed around it";
    EXPECT_GT(inside_mm, 2 * std::numbers::pi * 23 * 0.8) << lobes;
  }
}

TEST(LassoPrompt, LeavesMoreSpaceAroundAStart) {
  const auto contour = lobed({50, 50, 20}, 25, 0);
  const PlaneContour plane(contour, {0, 0, 1});
  for (const bool starts : {false, true})
    for (const PromptStroke& stroke : prompt_of_lasso(MarkKind::Inside, contour, {0, 0, 1}, cube_of(100), starts))
      for (const Eigen::Vector3d& at : stroke.path_mm)
        if (stroke.kind == MarkKind::Outside) {
          EXPECT_NEAR(plane.distance_mm(at), starts ? 5 : 2, 0.3);
        }
}

TEST(LassoPrompt, FillsItsInterior) {
  const auto contour = lobed({50, 50, 20}, 30, 0);
  const auto strokes = prompt_of_lasso(MarkKind::Inside, contour, {0, 0, 1}, cube_of(100));
  int covered = 0, all = 0;
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x) {
      const Eigen::Vector3d at(x, y, 20);
      if ((at - Eigen::Vector3d(50, 50, 20)).norm() > 27) continue;
      ++all;
      bool reached = false;
      for (const PromptStroke& stroke : strokes)
        for (const Eigen::Vector3d& vertex : stroke.path_mm)
          reached |= stroke.kind == MarkKind::Inside && (vertex - at).norm() <= stroke.radius_mm;
      covered += reached;
    }
  EXPECT_GT(covered, 0.6 * all);
}

TEST(LassoPrompt, OutsideMarksOnlyWhatItEncloses) {
  const auto contour = lobed({50, 50, 20}, 10, 0);
  const PlaneContour plane(contour, {0, 0, 1});
  const auto strokes = prompt_of_lasso(MarkKind::Outside, contour, {0, 0, 1}, cube_of(100));
  ASSERT_FALSE(strokes.empty());
  for (const PromptStroke& stroke : strokes) {
    EXPECT_EQ(stroke.kind, MarkKind::Outside);
    for (const Eigen::Vector3d& at : stroke.path_mm) EXPECT_TRUE(plane.encloses(at));
  }
}

TEST(LassoPrompt, StaysInTheVolumeAndNeedsAnInterior) {
  const VolumeGeometry volume = cube_of(100);
  for (const PromptStroke& stroke : prompt_of_lasso(MarkKind::Inside, lobed({2, 50, 20}, 25, 0), {0, 0, 1}, volume))
    for (const Eigen::Vector3d& at : stroke.path_mm) EXPECT_TRUE(volume.contains(at));
  EXPECT_FALSE(prompt_of_lasso(MarkKind::Inside, lobed({50, 50, 20}, 1.2, 0), {0, 0, 1}, volume).empty());
  EXPECT_THROW(prompt_of_lasso(MarkKind::Inside, lobed({50, 50, 20}, 0.1, 0), {0, 0, 1}, volume), Error);
  EXPECT_THROW(prompt_of_lasso(MarkKind::Inside, lobed({-80, 50, 20}, 25, 0), {0, 0, 1}, volume), Error);
  EXPECT_THROW(prompt_of_lasso(MarkKind::Boundary, lobed({50, 50, 20}, 25, 0), {0, 0, 1}, volume), Error);
  const std::vector<Eigen::Vector3d> same(5, Eigen::Vector3d(50, 50, 20));
  EXPECT_THROW(prompt_of_lasso(MarkKind::Inside, same, {0, 0, 1}, volume), Error);
}

TEST(LassoSeed, LiesWhereTheContourIsFarthest) {
  const VolumeGeometry volume = cube_of(100);
  const Mark seed = seed_of_lasso(lobed({50, 40, 20}, 24, 0), {0, 0, 1}, volume);
  EXPECT_LT((seed.position_mm - Eigen::Vector3d(50, 40, 20)).norm(), 0.2);
  EXPECT_NEAR(seed.radius_mm, 0.4 * 24, 0.2);
  // A large and a small square, joined by a narrow part.
  const std::vector<Eigen::Vector3d> joined{{10, 10, 5}, {50, 10, 5}, {50, 29, 5}, {70, 29, 5},
                                            {70, 25, 5}, {80, 25, 5}, {80, 35, 5}, {70, 35, 5},
                                            {70, 31, 5}, {50, 31, 5}, {50, 50, 5}, {10, 50, 5}};
  const Mark large = seed_of_lasso(joined, {0, 0, 1}, volume);
  EXPECT_LT((large.position_mm - Eigen::Vector3d(30, 30, 5)).norm(), 1);
  EXPECT_EQ(large.kind, MarkKind::Inside);
  EXPECT_NEAR(seed_of_lasso(lobed({50, 40, 20}, 1.5, 0), {0, 0, 1}, volume).radius_mm, 1, 1e-9) << "at least a voxel";
  EXPECT_THROW(seed_of_lasso(lobed({-80, 40, 20}, 24, 0), {0, 0, 1}, volume), Error);
  EXPECT_THROW(seed_of_lasso(std::vector<Eigen::Vector3d>(2), {0, 0, 1}, volume), Error);
}

TEST(LassoSeed, StartsASegmentationAtLeastAsWellAsABall) {
  const auto dice = [](const Scene& scene, bool lasso) {
    FieldSubject<> subject(scene.image, run_serially());
    RobotSettings settings;
    settings.most_clicks = 0;
    settings.starts_with_lasso = lasso;
    settings.seed_scale = 0.8, settings.seed_offset = 0.2;  // the lasso has the noise of a hand, too
    return run_robot(scene.truth, subject, settings, [](int, const Mask&) {}).at(0).agreement.dice;
  };
  for (const Scene& scene :
       {ellipsoid(64, 1, {18, 18, 18}, 15), ellipsoid(64, 1, {26, 16, 12}, 15), ellipsoid(64, 3, {24, 18, 18}, 15)}) {
    const double ball = dice(scene, false), contour = dice(scene, true);
    EXPECT_GE(contour, ball - 0.005) << "ball " << ball;
    EXPECT_GT(contour, 0.98);
  }
}

}  // namespace
}  // namespace simplexseg
