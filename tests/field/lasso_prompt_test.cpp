// SPDX-License-Identifier: Apache-2.0
#include "field/lasso_prompt.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
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

}  // namespace
}  // namespace simplexseg
