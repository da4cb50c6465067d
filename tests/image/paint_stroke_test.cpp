// SPDX-License-Identifier: Apache-2.0
#include "image/paint_stroke.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/error.h"

namespace simplexseg {
namespace {

VolumeGeometry oblique_grid() {
  VolumeGeometry grid;
  grid.size = {23, 19, 17};
  grid.spacing_mm = {0.8, 1.1, 2.5};
  grid.origin_mm = {-3, 4, -10};
  grid.direction = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  return grid;
}
double distance_to_path(const Eigen::Vector3d& p, const std::vector<Eigen::Vector3d>& path) {
  double nearest = (p - path[0]).norm();
  for (std::size_t s = 1; s < path.size(); ++s)
    for (int t = 0; t <= 500; ++t)
      nearest = std::min(nearest, (p - path[s - 1] - t / 500.0 * (path[s] - path[s - 1])).norm());
  return nearest;
}

TEST(PaintStroke, SetsTheVoxelsWithinItsRadius) {
  const VolumeGeometry grid = oblique_grid();
  const Eigen::Affine3d world = grid.world_from_index();
  std::mt19937 random(4);
  std::uniform_real_distribution<double> share(-0.1, 1.1);
  for (int trial = 0; trial < 20; ++trial) {
    PaintStroke stroke;
    stroke.radius_mm = 1 + trial % 5;
    for (int vertex = 0; vertex < 1 + trial % 4; ++vertex)
      stroke.vertices_mm.emplace_back(world *
                                      Eigen::Vector3d(23 * share(random), 19 * share(random), 17 * share(random)));
    const Eigen::Vector3d normal = world.linear().col(2).normalized();
    if (trial % 2) stroke.brush = PaintBrush::disc(normal, 2.5);
    Mask mask{grid, std::vector<std::uint8_t>(grid.voxel_count())};
    apply(stroke, mask);
    std::size_t v = 0;
    for (int k = 0; k < 17; ++k)
      for (int j = 0; j < 19; ++j)
        for (int i = 0; i < 23; ++i, ++v) {
          const Eigen::Vector3d mm = world * Eigen::Vector3d(i, j, k);
          const double off = normal.dot(mm - stroke.vertices_mm[0]);
          const auto flat = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
            return trial % 2 ? Eigen::Vector3d(p - normal.dot(p - stroke.vertices_mm[0]) * normal) : p;
          };
          std::vector<Eigen::Vector3d> path;
          for (const Eigen::Vector3d& vertex : stroke.vertices_mm) path.push_back(flat(vertex));
          const double distance = distance_to_path(flat(mm), path);
          const bool in_slice = trial % 2 == 0 || (off >= -1.25 && off < 1.25);
          bool expected = distance <= stroke.radius_mm && in_slice;
          for (const Eigen::Vector3d& vertex : path)
            expected |= in_slice && (world.inverse() * vertex - Eigen::Vector3d(i, j, k)).cwiseAbs().maxCoeff() < 0.5;
          if (std::abs(distance - stroke.radius_mm) > 0.01) {
            ASSERT_EQ(mask.voxels[v] != 0, expected) << trial << ": " << i << " " << j << " " << k;
          }
        }
    stroke.inside = false;
    apply(stroke, mask);
    EXPECT_EQ(std::count(mask.voxels.begin(), mask.voxels.end(), 1), 0);
  }
}

TEST(PaintStroke, OfADiscPaintsOneSliceWhereverItsCentreIs) {
  VolumeGeometry grid;
  grid.size = {20, 20, 20};
  grid.spacing_mm = {1, 1, 3};
  for (const double z : {27.0, 27.4, 28.4999, 28.5, 29.0}) {
    PaintStroke stroke{true, {{9, 9, z}}, 4, PaintBrush::disc({0, 0, 1}, 3)};
    const StrokeVoxels found = voxels_of(stroke, grid);
    std::size_t v = 0;
    for (int k = 0; k < found.box.size[2]; ++k)
      for (int p = 0; p < found.box.size[0] * found.box.size[1]; ++p, ++v)
        if (found.voxels[v] != VoxelPaint::None) {
          EXPECT_EQ(found.box.first[2] + k, z <= 28.5 ? 9 : 10) << z;
        }
    EXPECT_EQ(std::count(found.voxels.begin(), found.voxels.end(), VoxelPaint::Inside), 49) << z;
  }
}

/// Whether the contour turns about a place: sum of the angles that its sides subtend.
bool turns_about(const std::vector<Eigen::Vector3d>& contour, const Eigen::Vector3d& normal, const Eigen::Vector3d& p) {
  double turns = 0;
  for (std::size_t n = 0; n < contour.size(); ++n) {
    Eigen::Vector3d a = contour[n] - p, b = contour[(n + 1) % contour.size()] - p;
    a -= a.dot(normal) * normal, b -= b.dot(normal) * normal;
    turns += std::atan2(a.cross(b).dot(normal), a.dot(b));
  }
  return std::abs(turns) > 3;
}

TEST(PaintStroke, OfAContourSetsWhatItEncloses) {
  const VolumeGeometry grid = oblique_grid();
  const Eigen::Affine3d world = grid.world_from_index();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(-0.1, 1.1);
  for (int trial = 0; trial < 24; ++trial) {
    // In a slice of the grid, or oblique; through the volume, or a slab; with sides that cross.
    const Eigen::Vector3d normal =
        trial % 2 ? Eigen::Vector3d(world.linear().col(2).normalized()) : Eigen::Vector3d(0.6, 0, 0.8);
    const double thickness = trial % 3 ? 2.5 : 0;
    PaintStroke stroke{true, {}, 0, PaintBrush::contour(normal, thickness)};
    const Eigen::Vector3d centre = world * Eigen::Vector3d(11, 9, 8.2), u = normal.unitOrthogonal();
    for (int vertex = 0; vertex < 3 + trial % 5; ++vertex)
      stroke.vertices_mm.emplace_back(centre + 20 * (share(random) - 0.5) * u +
                                      20 * (share(random) - 0.5) * normal.cross(u));
    // Vertices beside the plane are projected onto it.
    if (trial % 4 == 3) stroke.vertices_mm[1] += 5 * normal;
    Mask mask{grid, std::vector<std::uint8_t>(grid.voxel_count())};
    apply(stroke, mask);
    int set = 0;
    std::size_t v = 0;
    for (int k = 0; k < grid.size[2]; ++k)
      for (int j = 0; j < grid.size[1]; ++j)
        for (int i = 0; i < grid.size[0]; ++i, ++v) {
          const Eigen::Vector3d mm = world * Eigen::Vector3d(i, j, k);
          const double off = normal.dot(mm - centre);
          const bool in_slab = thickness == 0 || (off >= -thickness / 2 && off < thickness / 2);
          ASSERT_EQ(mask.voxels[v] != 0, in_slab && turns_about(stroke.vertices_mm, normal, mm)) << trial;
          set += mask.voxels[v];
        }
    EXPECT_GT(set, 0) << trial;
  }
}

TEST(PaintStroke, OfASetOfVoxelsSetsThemOnAnyGrid) {
  const VolumeGeometry grid = oblique_grid();
  std::mt19937 random(6);
  Mask before{grid, std::vector<std::uint8_t>(grid.voxel_count())}, after = before;
  const VoxelBox all{{0, 0, 0}, grid.size};
  for (int k = 3; k < 9; ++k)
    for (int j = 2; j < 11; ++j)
      for (int i = 5; i < 12; ++i) {
        before.voxels[all.offset(i, j, k)] = random() % 2;
        after.voxels[all.offset(i, j, k)] = random() % 2;
      }
  EXPECT_EQ(difference_of(before, before), nullptr);
  const auto voxels = difference_of(before, after);
  EXPECT_EQ(voxels->box.size, (std::array{7, 9, 6}));
  EXPECT_EQ(voxels_of_runs(runs_of(voxels->voxels), voxels->voxels.size()), voxels->voxels);
  const PaintStroke stroke{true, {}, 0, {PaintBrush::Shape::Voxels}, voxels};
  Mask changed = before;
  apply(stroke, changed);
  EXPECT_EQ(changed.voxels, after.voxels);
  // Each voxel divided into 27 samples.
  VolumeGeometry fine = grid;
  for (int a = 0; a < 3; ++a) fine.size[a] *= 3;
  fine.spacing_mm /= 3;
  fine.origin_mm = grid.world_from_index() * Eigen::Vector3d(-1 / 3.0, -1 / 3.0, -1 / 3.0);
  int samples = 0;
  voxels_of(stroke, fine).for_each([&](int i, int j, int k, bool inside) {
    ++samples;
    ASSERT_EQ(inside, after.voxels[all.offset(i / 3, j / 3, k / 3)] != 0);
    ASSERT_NE(inside, before.voxels[all.offset(i / 3, j / 3, k / 3)] != 0);
  });
  const auto set = std::ranges::count_if(voxels->voxels, [](VoxelPaint paint) { return paint != VoxelPaint::None; });
  EXPECT_EQ(samples, 27 * set);
  EXPECT_THROW(voxels_of_runs(runs_of(voxels->voxels), voxels->voxels.size() + 1), Error);
}

TEST(PaintStroke, OutsideTheGridSetsNothing) {
  const VolumeGeometry grid = oblique_grid();
  EXPECT_TRUE(voxels_of({true, {{500, 0, 0}}, 3}, grid).voxels.empty());
  EXPECT_TRUE(voxels_of({true, {{0, 0, 0}}, 3}, grid, VoxelBox{{2, 2, 2}, {0, 0, 0}}).voxels.empty());
}

}  // namespace
}  // namespace simplexseg
