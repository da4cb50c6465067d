// SPDX-License-Identifier: Apache-2.0
// Long and short axis of objects whose axes are known.
#include "image/object_axes.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "mesh/iso_surface.h"
#include "mesh/plane_section.h"

namespace simplexseg {
namespace {

VolumeGeometry grid(const std::array<int, 3>& size, const Eigen::Vector3d& spacing_mm) {
  VolumeGeometry geometry;
  geometry.size = size;
  geometry.spacing_mm = spacing_mm;
  geometry.origin_mm = -0.5 * spacing_mm.cwiseProduct(Eigen::Vector3d(size[0] - 1, size[1] - 1, size[2] - 1));
  return geometry;
}

/// Fine mesh of an ellipsoid around the origin. `axes`: its semi-axes, mm, as columns.
SimplexMesh ellipsoid(const Eigen::Matrix3d& axes) {
  SimplexMesh mesh = make_sphere({0, 0, 0}, 1, 5);
  for (Eigen::Vector3f& p : mesh.positions) p = (axes * p.cast<double>()).cast<float>();
  return mesh;
}

/// Semi-axes of the section of an ellipsoid around the origin with the plane z = 0: the square roots of the eigenvalues
/// of the inverse of the upper left block of (A A^T)^-1.
Eigen::Vector2d section_axes(const Eigen::Matrix3d& axes) {
  const Eigen::Matrix2d form = (axes * axes.transpose()).inverse().topLeftCorner<2, 2>();
  const Eigen::Vector2d eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(form).eigenvalues();
  return {1 / std::sqrt(eigenvalues[0]), 1 / std::sqrt(eigenvalues[1])};
}

TEST(ObjectAxes, OfATiltedEllipsoidAreThoseOfItsLargestSection) {
  for (const double tilt : {0.0, 0.4, 1.1}) {
    const Eigen::Matrix3d turn = (Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(tilt, Eigen::Vector3d(1, 0.5, 0).normalized()))
                                     .toRotationMatrix();
    const Eigen::Matrix3d axes = turn * Eigen::Vector3d(20, 12, 9).asDiagonal();
    const auto found = object_axes(ellipsoid(axes), grid({65, 65, 61}, {1, 1, 1}));
    ASSERT_TRUE(found) << tilt;
    // Sections of an ellipsoid are similar, so the largest one passes through the centre, which is slice 31.
    const Eigen::Vector2d exact = 2 * section_axes(axes);
    EXPECT_EQ(found->slice, 31) << tilt;
    EXPECT_NEAR(found->long_mm(), exact[0], 0.02) << tilt;
    EXPECT_NEAR(found->short_mm(), exact[1], 0.02) << tilt;
    const Eigen::Vector3d along = found->long_ends_mm[1] - found->long_ends_mm[0],
                          across = found->short_ends_mm[1] - found->short_ends_mm[0];
    EXPECT_NEAR(along.normalized().dot(across.normalized()), 0, 1e-9);
    for (const Eigen::Vector3d& end : {found->long_ends_mm[0], found->short_ends_mm[1]}) EXPECT_NEAR(end.z(), 0, 1e-9);
  }
}

/// Mesh of the level 0 of a function, on a grid of 1 mm of this half width.
template <class Value>
SimplexMesh level_set(int half, const Value& value) {
  const int side = 2 * half + 1;
  std::vector<float> values;
  for (int k = -half; k <= half; ++k)
    for (int j = -half; j <= half; ++j)
      for (int i = -half; i <= half; ++i) values.push_back(static_cast<float>(value(Eigen::Vector3d(i, j, k))));
  Eigen::Affine3d world = Eigen::Affine3d::Identity();
  world.translation() = Eigen::Vector3d::Constant(-half);
  return dual_of(iso_surface(values, {side, side, side}, 0, world));
}

TEST(ObjectAxes, OfARotatedBoxAreItsDiagonalAndTheChordAcross) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const SimplexMesh box = level_set(24, [&](const Eigen::Vector3d& p) {
    const Eigen::Vector3d q = (turn.transpose() * p).cwiseAbs() - Eigen::Vector3d(16, 8, 10);
    return -q.maxCoeff();
  });
  const auto found = object_axes(box, grid({49, 49, 49}, {1, 1, 1}));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->long_mm(), std::hypot(32, 16), 1);
  // The longest line across the diagonal joins a corner with the opposite long side: 16 / cos(atan(16 / 32)).
  EXPECT_NEAR(found->short_mm(), 16 / std::cos(std::atan(0.5)), 1);
}

TEST(ObjectAxes, AreThoseOfAllPairsOfPointsInAllSlices) {
  const SimplexMesh mesh = level_set(20, [](const Eigen::Vector3d& p) {  // two balls joined by a bridge, a slanted hole
    const double balls =
        std::max(7 - (p - Eigen::Vector3d(8, 3, 5)).norm(), 9 - (p - Eigen::Vector3d(-7, -2, -3)).norm());
    const double bridge = 3.2 - std::hypot(p.y() - p.x() / 3, p.z() - 0.5 * p.x() - 0.5);
    const double hole = 2.1 - std::hypot(p.x() + 7, p.y() + 2 - 0.2 * p.z());
    return std::min(std::max(balls, std::min(bridge, 9 - std::abs(p.x()))), -hole);
  });
  for (const Eigen::Vector3d& spacing : {Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(0.7, 1.3, 2.5)}) {
    VolumeGeometry geometry = grid({64, 64, 30}, spacing);
    geometry.direction.col(0) *= -1;  // left-handed
    geometry.origin_mm[0] *= -1;
    const auto found = object_axes(mesh, geometry);
    ASSERT_TRUE(found);
    double longest = 0;
    const auto sections = plane_sections(mesh, geometry.index_from_world(), geometry.size[2]);
    for (const auto& section : sections)
      for (const Polygon& contour : section)
        for (const Eigen::Vector2d& a : contour)
          for (const Eigen::Vector2d& b : contour)
            longest = std::max(longest, (a - b).cwiseProduct(spacing.head<2>()).norm());
    EXPECT_NEAR(found->long_mm(), longest, 1e-9);
    const double z = geometry.origin_mm.z() + (found->slice - 1) * spacing.z();
    for (const Eigen::Vector3d& end : found->long_ends_mm) EXPECT_NEAR(end.z(), z, 1e-9);
    EXPECT_LE(found->short_mm(), found->long_mm() + 1e-9);
  }
}

TEST(ObjectAxes, AreMeasuredInAxialSlicesOfAnyGrid) {
  const Eigen::Matrix3d axes = Eigen::Vector3d(6, 10, 30).asDiagonal();
  // Sagittal acquisition: the voxel axes i, j, k are y, z downwards and x.
  VolumeGeometry geometry = grid({60, 80, 40}, {1, 1, 1});
  geometry.direction << 0, 0, 1, 1, 0, 0, 0, -1, 0;
  geometry.origin_mm = -(geometry.direction * Eigen::Vector3d(30, 40, 20));
  const auto found = object_axes(ellipsoid(axes), geometry);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->long_mm(), 20, 0.02);
  EXPECT_NEAR(found->short_mm(), 12, 0.02);
  EXPECT_EQ(found->slice, 80 - 40) << "counted from the feet";
}

TEST(ObjectAxes, OfPartsOfASectionDoNotJoinThem) {
  const SimplexMesh pair = level_set(20, [](const Eigen::Vector3d& p) {  // a U, whose legs reach higher slices
    const double legs = 4 - std::hypot(std::abs(p.x()) - 10, p.y());
    return std::min(std::max(legs, std::min(4 - std::hypot(p.y(), p.z() + 10), 12 - std::abs(p.x()))),
                    14 - std::abs(p.z()));
  });
  VolumeGeometry upper = grid({41, 41, 10}, {1, 1, 1});
  upper.origin_mm.z() = 0;
  const auto parts = object_axes(pair, upper), whole = object_axes(pair, grid({41, 41, 41}, {1, 1, 1}));
  ASSERT_TRUE(parts && whole);
  EXPECT_NEAR(parts->long_mm(), 8, 0.2) << "one leg";
  EXPECT_GT(whole->long_mm(), 27) << "the slice that joins both";
}

TEST(ObjectAxes, NeedASliceThatCutsTheMesh) {
  VolumeGeometry geometry = grid({20, 20, 1}, {1, 1, 1});
  geometry.origin_mm.z() = 50;
  EXPECT_FALSE(object_axes(make_sphere({0, 0, 0}, 5, 2), geometry));
  EXPECT_FALSE(object_axes({}, geometry));
}

}  // namespace
}  // namespace simplexseg
