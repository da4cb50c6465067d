// SPDX-License-Identifier: Apache-2.0
#include "mesh/iso_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "genus.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

std::vector<float> grid_of(const std::array<int, 3>& size, const std::function<double(const Eigen::Vector3d&)>& f) {
  std::vector<float> values;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) values.push_back(static_cast<float>(f(Eigen::Vector3d(i, j, k))));
  return values;
}

TEST(IsoSurface, OfABallIsASphereForAnyGeometry) {
  const std::array<int, 3> size{24, 22, 26};
  const auto values =
      grid_of(size, [](const Eigen::Vector3d& p) { return 8 - (p - Eigen::Vector3d(12, 11, 13)).norm(); });
  Eigen::Affine3d geometry = Eigen::Affine3d::Identity();
  geometry.linear() << 0.5, 0, 0, 0, 0, -0.5, 0, 0.5, 0;  // rotated: j is -z, k is y
  geometry.translation() = Eigen::Vector3d(100, -30, 7);
  for (const bool mirrored : {false, true}) {
    Eigen::Affine3d mm = geometry;
    if (mirrored) mm.linear().col(0) *= -1;
    const SimplexMesh mesh = dual_of(iso_surface(values, size, 0, mm));
    EXPECT_NO_THROW(validate(mesh));
    EXPECT_EQ(one_less_genus(mesh), 1);
    const SurfaceMeasures m = measure(mesh);
    EXPECT_NEAR(m.volume_mm3, 4.0 / 3 * std::numbers::pi * 64, 0.05 * 268) << "outward, " << mirrored;
    EXPECT_LT((m.centroid_mm - mm * Eigen::Vector3d(12, 11, 13)).norm(), 0.1);
  }
}

TEST(IsoSurface, KeepsHolesAndParts) {
  const std::array<int, 3> size{40, 40, 16};
  const auto torus = grid_of(size, [](const Eigen::Vector3d& p) {
    const double ring = std::hypot(p[0] - 20, p[1] - 20) - 12;
    return 4 - std::hypot(ring, p[2] - 8);
  });
  EXPECT_EQ(one_less_genus(dual_of(iso_surface(torus, size, 0, Eigen::Affine3d::Identity()))), 0);
  const auto two = grid_of(size, [](const Eigen::Vector3d& p) {
    return 5 - std::min((p - Eigen::Vector3d(8, 8, 8)).norm(), (p - Eigen::Vector3d(30, 30, 8)).norm());
  });
  const SimplexMesh parts = dual_of(iso_surface(two, size, 0, Eigen::Affine3d::Identity()));
  EXPECT_NO_THROW(validate(parts));
  EXPECT_EQ(one_less_genus(parts), 2);
}

TEST(IsoSurface, IsClosedWhereTheObjectIsCutByTheGridAndEmptyWithoutOne) {
  const std::array<int, 3> size{5, 4, 3};
  const std::vector<float> full(60, 1.0f);
  const SimplexMesh mesh = dual_of(iso_surface(full, size, 0.5f, Eigen::Affine3d::Identity()));
  EXPECT_NO_THROW(validate(mesh));
  EXPECT_TRUE(iso_surface(std::vector<float>(60, 0.0f), size, 0.5f, Eigen::Affine3d::Identity()).triangles.empty());
  // Noise is the hardest input: touching corners and holes of one voxel.
  std::vector<float> noise(4000);
  unsigned state = 1;
  for (float& x : noise) x = static_cast<float>((state = state * 1664525u + 1013904223u) >> 8) / (1 << 24);
  EXPECT_NO_THROW(validate(dual_of(iso_surface(noise, {20, 20, 10}, 0.6f, Eigen::Affine3d::Identity()))));
}

}  // namespace
}  // namespace simplexseg
