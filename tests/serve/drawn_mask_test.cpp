// SPDX-License-Identifier: Apache-2.0
// Scribbles and lassos of clients: strokes and contours from voxels.
#include "serve/drawn_mask.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/error.h"
#include "image/plane_contour.h"

namespace simplexseg {
namespace {

/// Mask on a grid with different spacings, set where `is_set(i, j, k)`.
Mask drawn_where(const std::function<bool(int, int, int)>& is_set) {
  VolumeGeometry grid;
  grid.size = {40, 36, 12};
  grid.spacing_mm = {1, 1, 3};
  grid.origin_mm = {-20, 7, 100};
  Mask mask{grid, {}};
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) mask.voxels.push_back(is_set(i, j, k));
  return mask;
}

/// Largest distance of a set voxel to the nearest vertex of the paths, mm.
double farthest_mm(const Mask& mask, const std::vector<std::vector<Eigen::Vector3d>>& paths) {
  double farthest = 0;
  std::size_t v = 0;
  for (int k = 0; k < mask.geometry.size[2]; ++k)
    for (int j = 0; j < mask.geometry.size[1]; ++j)
      for (int i = 0; i < mask.geometry.size[0]; ++i, ++v) {
        if (mask.voxels[v] == 0) continue;
        const Eigen::Vector3d mm = mask.geometry.world_from_index() * Eigen::Vector3d(i, j, k);
        double nearest = kInfinity;
        for (const auto& path : paths)
          for (const Eigen::Vector3d& vertex : path) nearest = std::min(nearest, (vertex - mm).norm());
        farthest = std::max(farthest, nearest);
      }
  return farthest;
}

TEST(DrawnMask, AScribbleIsOnePathAlongItsMiddle) {
  const Mask mask = drawn_where([](int i, int j, int k) { return k == 5 && i >= 5 && i < 30 && (j == 10 || j == 11); });
  const auto paths = paths_of_scribble(mask);
  ASSERT_EQ(paths.size(), 1u);
  EXPECT_NEAR((paths[0].front() - paths[0].back()).norm(), 24, 1.5);
  EXPECT_LT(farthest_mm(mask, paths), 1.5);
  for (const Eigen::Vector3d& mm : paths[0]) EXPECT_NEAR(mm.z(), 100 + 5 * 3, 1e-9);
}

TEST(DrawnMask, BranchesAndClosedScribblesAreCovered) {
  const Mask cross = drawn_where([](int i, int j, int k) {
    return k == 5 && ((std::abs(i - 20) < 2 && j > 4 && j < 32) || (std::abs(j - 18) < 2 && i > 4 && i < 36));
  });
  const Mask ring = drawn_where([](int i, int j, int k) {
    const double r = std::hypot(i - 20, j - 18);
    return k == 5 && r > 10 && r < 12.5;
  });
  for (const Mask* mask : {&cross, &ring}) {
    const auto paths = paths_of_scribble(*mask);
    EXPECT_GT(paths.size(), 1u);
    EXPECT_LT(farthest_mm(*mask, paths), 5);
  }
}

TEST(DrawnMask, EachSliceHasItsOwnPath) {
  const Mask mask = drawn_where([](int i, int j, int k) { return (k == 2 || k == 3) && j == 9 && i > 4 && i < 20; });
  EXPECT_EQ(paths_of_scribble(mask).size(), 1u) << "thinnest along j: one slice with both rows";
  const Mask apart = drawn_where([](int i, int j, int k) { return (k == 2 || k == 8) && j > 8 && j < 20 && i == j; });
  EXPECT_EQ(paths_of_scribble(apart).size(), 2u) << "oblique lines of one voxel are connected";
  EXPECT_LT(farthest_mm(apart, paths_of_scribble(apart)), 1.5);
  const Mask marks = drawn_where([](int i, int j, int k) { return k == 2 && j == 9 && (i == 4 || i == 9 || i == 30); });
  EXPECT_EQ(paths_of_scribble(marks).size(), 3u) << "single voxels far apart";
}

TEST(DrawnMask, FilledLassosAndLinesGiveTheSameContour) {
  const auto radius = [](int i, int j) { return std::hypot(i - 20, j - 18); };
  const Mask filled = drawn_where([&](int i, int j, int k) { return k == 4 && radius(i, j) < 11; });
  const Mask line = drawn_where([&](int i, int j, int k) { return k == 4 && radius(i, j) >= 10 && radius(i, j) < 12; });
  for (const Mask* mask : {&filled, &line}) {
    const std::vector<DrawnContour> contours = contours_of_lasso(*mask);
    ASSERT_EQ(contours.size(), 1u);
    EXPECT_NEAR(std::abs(contours[0].normal.z()), 1, 1e-9);
    const PlaneContour contour(contours[0].contour_mm, contours[0].normal);
    const Eigen::Vector3d centre = mask->geometry.world_from_index() * Eigen::Vector3d(20, 18, 4);
    EXPECT_TRUE(contour.encloses(centre));
    for (const Eigen::Vector3d& mm : contours[0].contour_mm) EXPECT_NEAR((mm - centre).norm(), 11, 1.3);
  }
}

TEST(DrawnMask, SmallHolesOfAFilledLassoAreFilledAndCrumbsOmitted) {
  const Mask mask = drawn_where([](int i, int j, int k) {
    if (k != 4) return false;
    if (i == 2 && j == 2) return true;
    return std::hypot(i - 20, j - 18) < 11 && !(i == 20 && j == 18);
  });
  const std::vector<DrawnContour> contours = contours_of_lasso(mask);
  ASSERT_EQ(contours.size(), 1u);
  const Eigen::Vector3d centre = mask.geometry.world_from_index() * Eigen::Vector3d(20, 18, 4);
  double farthest = 0;
  for (const Eigen::Vector3d& mm : contours[0].contour_mm) farthest = std::max(farthest, (mm - centre).norm());
  EXPECT_NEAR(farthest, 11, 1.3);
}

TEST(DrawnMask, EmptyMasksAndManyPartsAreRefused) {
  const Mask nothing = drawn_where([](int, int, int) { return false; });
  EXPECT_THROW(paths_of_scribble(nothing), Error);
  EXPECT_THROW(contours_of_lasso(nothing), Error);
  const Mask crumbs = drawn_where([](int i, int j, int k) { return k == 3 && i % 4 < 2 && j % 4 < 2; });
  EXPECT_THROW(paths_of_scribble(crumbs), Error);
  EXPECT_THROW(contours_of_lasso(crumbs), Error);
}

}  // namespace
}  // namespace simplexseg
