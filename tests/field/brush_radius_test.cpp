// SPDX-License-Identifier: Apache-2.0
#include "field/brush_radius.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ellipsoid_scene.h"

namespace simplexseg {
namespace {

/// The radius is the distance to the nearest cell of the other side, from the smallest radius to that far away; the
/// expectation searches all cells.
TEST(BrushRadius, IsTheDistanceToTheSurfaceWithinItsBounds) {
  const Scene scene = ellipsoid(40, 2, {10, 12, 9}, 5);
  const VolumeGeometry& grid = scene.image.geometry();
  const VoxelBox box{{3, 5, 2}, {32, 30, 16}};
  std::vector<std::uint8_t> object;
  std::vector<Eigen::Vector3d> cells_mm;
  const Eigen::Affine3d world = grid.world_from_index();
  for (int k = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j)
      for (int i = 0; i < box.size[0]; ++i) {
        const Eigen::Vector3i at(i + box.first[0], j + box.first[1], k + box.first[2]);
        object.push_back(scene.truth.voxels[scene.truth.geometry.size[0] *
                                                (scene.truth.geometry.size[1] * std::size_t(at.z()) + at.y()) +
                                            at.x()]);
        cells_mm.push_back(world * at.cast<double>());
      }
  const EvidenceSettings settings;
  const double voxel_mm = grid.spacing_mm.minCoeff(), far = settings.brush * voxel_mm;
  EXPECT_DOUBLE_EQ(far_brush_radius_mm(grid), far);
  int at_surface = 0, between = 0, far_away = 0;
  for (const MarkKind kind : {MarkKind::Inside, MarkKind::Outside})
    for (double z = -20; z <= 20; z += 0.7) {
      const Eigen::Vector3d click(1.3, -0.4, z);
      double nearest = far;
      for (std::size_t v = 0; v < object.size(); ++v)
        if ((object[v] != 0) == (kind == MarkKind::Inside)) nearest = std::min(nearest, (cells_mm[v] - click).norm());
      const double expected = std::max(nearest, settings.smallest_brush * voxel_mm);
      EXPECT_NEAR(brush_radius_mm(grid, box, object, kind, click), expected, 1e-9) << z;
      (expected == far ? far_away : expected == nearest ? between : at_surface)++;
    }
  EXPECT_GT(at_surface, 3);
  EXPECT_GT(between, 3);
  EXPECT_GT(far_away, 3);
  EXPECT_DOUBLE_EQ(brush_radius_mm(grid, box, object, MarkKind::Boundary, {0, 0, 9}), far);
  EXPECT_DOUBLE_EQ(brush_radius_mm(grid, box, object, MarkKind::Outside, {500, 0, 0}), far) << "outside the box";
}

}  // namespace
}  // namespace simplexseg
