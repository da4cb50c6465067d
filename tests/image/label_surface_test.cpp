// SPDX-License-Identifier: Apache-2.0
#include "image/label_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/error.h"
#include "image/metrics.h"
#include "image/rasterise.h"
#include "image/surface_error.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

/// Rotated, left-handed grid with anisotropic voxels.
VolumeGeometry odd_grid(const std::array<int, 3>& size) {
  VolumeGeometry grid;
  grid.size = size;
  grid.spacing_mm = {0.8, 1.1, 1.5};
  grid.origin_mm = {-100, 30, 500};
  grid.direction.col(0) = Eigen::Vector3d(0.6, 0.8, 0);
  grid.direction.col(1) = Eigen::Vector3d(0, 0, 1);
  grid.direction.col(2) = Eigen::Vector3d(-0.8, 0.6, 0);
  return grid;
}

/// Mask of the voxels with f(index) > 0.
Mask mask_where(const VolumeGeometry& grid, const std::function<double(const Eigen::Vector3d&)>& f) {
  Mask mask{grid, {}};
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) mask.voxels.push_back(f(Eigen::Vector3d(i, j, k)) > 0);
  return mask;
}
Mask ball(double radius, const VolumeGeometry& grid) {
  const Eigen::Vector3d centre(grid.size[0] / 2 + 0.3, grid.size[1] / 2 + 0.1, grid.size[2] / 2 - 0.2);
  return mask_where(grid, [=](const Eigen::Vector3d& p) { return radius - (p - centre).norm(); });
}
VolumeGeometry cubic(int n) {
  VolumeGeometry grid;
  grid.size = {n, n, n};
  return grid;
}
double volume_of(const Mask& mask) {
  return static_cast<double>(std::count(mask.voxels.begin(), mask.voxels.end(), 1)) *
         std::abs(mask.geometry.world_from_index().linear().determinant());
}

TEST(LabelSurface, RasterisingTheMeshReproducesTheVoxels) {
  for (const VolumeGeometry& grid : {cubic(50), odd_grid({50, 50, 50})}) {
    const Mask mask = ball(20, grid);
    const SimplexMesh mesh = mesh_of_mask(mask);
    EXPECT_EQ(topology_of(mesh).surfaces, 1);
    EXPECT_EQ(topology_of(mesh).genus, 0);
    EXPECT_EQ(folded_vertices(mesh), 0);
    const Mask once = rasterise(mesh, grid);
    EXPECT_GT(dice(mask, once), 0.995);
    EXPECT_GT(dice(once, rasterise(mesh_of_mask(once), grid)), 0.99);
    EXPECT_NEAR(measure(mesh).volume_mm3 / volume_of(mask), 1, 1e-3);
    const SurfaceError::Values off = SurfaceError(mask).of(mesh.positions);
    EXPECT_LT(off.mean_mm, 0.2 * grid.spacing_mm.maxCoeff());
    EXPECT_LT(off.max_mm, 0.5 * grid.spacing_mm.maxCoeff());
  }
}

TEST(LabelSurface, HasTheRequestedVertexCount) {
  const Mask mask = ball(20, cubic(50));
  for (const int wanted : {300, 1500, 6000}) {
    const SimplexMesh mesh = mesh_of_mask(mask, wanted);
    EXPECT_NEAR(mesh.vertex_count(), wanted, 0.2 * wanted);
    EXPECT_NEAR(measure(mesh).volume_mm3 / volume_of(mask), 1, 0.01) << wanted;
  }
}

TEST(LabelSurface, ATorusKeepsItsHole) {
  VolumeGeometry grid = cubic(60);
  grid.size[2] = 20;
  const Mask torus = mask_where(
      grid, [](const Eigen::Vector3d& p) { return 6 - std::hypot(std::hypot(p[0] - 30, p[1] - 29) - 20, p[2] - 9.6); });
  for (const int vertices : {0, 500}) {
    const SimplexMesh mesh = mesh_of_mask(torus, vertices);
    EXPECT_EQ(topology_of(mesh).surfaces, 1);
    EXPECT_EQ(topology_of(mesh).genus, 1);
    EXPECT_LT(SurfaceError(torus).of(mesh.positions).mean_mm, 0.5);
    EXPECT_GT(dice(torus, rasterise(mesh, grid)), vertices ? 0.97 : 0.99);
  }
}

TEST(LabelSurface, PartsAndCavitiesAreSeparateSurfaces) {
  const Mask two = mask_where(cubic(40), [](const Eigen::Vector3d& p) {
    const double small = 5 - (p - Eigen::Vector3d(8, 8, 8)).norm();
    const double shell =
        std::min(9 - (p - Eigen::Vector3d(26, 26, 26)).norm(), (p - Eigen::Vector3d(26, 26, 26)).norm() - 4);
    return std::max(small, shell);
  });
  const auto parts = connected_components(two);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_GT(parts[0].size(), parts[1].size());
  EXPECT_EQ(parts[0].size() + parts[1].size(),
            static_cast<std::size_t>(std::count(two.voxels.begin(), two.voxels.end(), 1)));
  const SimplexMesh mesh = mesh_of_mask(two);
  EXPECT_EQ(topology_of(mesh).surfaces, 3);
  EXPECT_EQ(topology_of(mesh).genus, 0);
  EXPECT_GT(dice(two, rasterise(mesh, two.geometry)), 0.98) << "the cavity is empty";
  Mask small = two;
  std::fill(small.voxels.begin(), small.voxels.end(), 0);
  for (const std::size_t v : parts[1]) small.voxels[v] = 1;
  EXPECT_EQ(topology_of(mesh_of_mask(small)).surfaces, 1);
}

TEST(LabelSurface, SmallCavitiesCanBeFilled) {
  const auto ball = [](const Eigen::Vector3d& p, double x, double radius) {
    return radius - (p - Eigen::Vector3d(x, 14, 14)).norm();
  };
  const Mask solid = mask_where(cubic(28), [&](const Eigen::Vector3d& p) { return ball(p, 14, 12); });
  Mask holed = mask_where(cubic(28), [&](const Eigen::Vector3d& p) {
    return std::min({ball(p, 14, 12), -ball(p, 7, 0.5), -ball(p, 12, 1.5), -ball(p, 20, 3.5)});
  });
  Mask large =
      mask_where(cubic(28), [&](const Eigen::Vector3d& p) { return std::min(ball(p, 14, 12), -ball(p, 20, 3.5)); });
  EXPECT_EQ(topology_of(mesh_of_mask(holed)).surfaces, 4);
  EXPECT_EQ(fill_cavities(holed, 33), 2);
  EXPECT_TRUE(holed.voxels == large.voxels) << "the large one stays";
  EXPECT_EQ(topology_of(mesh_of_mask(holed)).surfaces, 2);
  EXPECT_EQ(fill_cavities(holed, 100000), 1);
  EXPECT_TRUE(holed.voxels == solid.voxels) << "and nothing outside is filled";
  // A dent at the image border is not a cavity.
  Mask border =
      mask_where(cubic(6), [](const Eigen::Vector3d& p) { return p[0] == 0 && p[1] == 2 && p[2] == 2 ? 0.0 : 1.0; });
  EXPECT_EQ(fill_cavities(border, 33), 0);
  Mask none = mask_where(cubic(3), [](const Eigen::Vector3d&) { return 0.0; });
  EXPECT_EQ(fill_cavities(none, 33), 0);
}

TEST(LabelSurface, VerySmallAndThinMasksGiveMeshes) {
  for (const auto& f : std::vector<std::function<double(const Eigen::Vector3d&)>>{
           [](const Eigen::Vector3d& p) { return 0.1 - (p - Eigen::Vector3d(0, 5, 11)).norm(); },
           [](const Eigen::Vector3d& p) { return p[2] == 6 ? 1.0 : 0.0; },
           [](const Eigen::Vector3d& p) { return p[0] == p[1] && p[1] == p[2] ? 1.0 : 0.0; }}) {
    const Mask mask = mask_where(cubic(12), f);
    const SimplexMesh mesh = mesh_of_mask(mask);
    EXPECT_NO_THROW(validate(mesh));
    EXPECT_EQ(topology_of(mesh).surfaces, 1);
    EXPECT_EQ(connected_components(mask).size(), 1u);
  }
  EXPECT_THROW(mesh_of_mask(mask_where(cubic(3), [](const Eigen::Vector3d&) { return 0.0; })), Error);
}

TEST(LabelSurface, TheInscribedBallLiesInTheThickestPart) {
  const VolumeGeometry grid = odd_grid({40, 40, 30});
  const Mask pear = mask_where(grid, [](const Eigen::Vector3d& p) {
    return std::max(9 - (p - Eigen::Vector3d(12, 14, 15)).norm(), 4 - (p - Eigen::Vector3d(24, 14, 15)).norm());
  });
  const InscribedBall found = largest_inscribed_ball(pear);
  EXPECT_LT((found.centre_mm - grid.world_from_index() * Eigen::Vector3d(12, 14, 15)).norm(), 2);
  EXPECT_NEAR(found.radius_mm, 9 * 0.8, 1);
  const Mask point =
      mask_where(grid, [](const Eigen::Vector3d& p) { return p == Eigen::Vector3d(0, 3, 4) ? 1.0 : 0.0; });
  EXPECT_NEAR(largest_inscribed_ball(point).radius_mm, 0.4, 1e-6);
  EXPECT_LT((largest_inscribed_ball(point).centre_mm - grid.world_from_index() * Eigen::Vector3d(0, 3, 4)).norm(),
            1e-9);
}

}  // namespace
}  // namespace simplexseg
