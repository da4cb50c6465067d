// SPDX-License-Identifier: Apache-2.0
#include "image/surface_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "image/mask.h"
#include "mesh/simplex_mesh.h"
#include "study/phantom.h"

namespace simplexseg {
namespace {

/// Sphere of radius r on a grid that may be anisotropic, sheared or too small for it.
Mask sphere_mask(double r, const Eigen::Vector3d& spacing,
                 const Eigen::Matrix3d& direction = Eigen::Matrix3d::Identity(), double margin = 6) {
  Mask mask;
  mask.geometry.spacing_mm = spacing;
  mask.geometry.direction = direction;
  for (int a = 0; a < 3; ++a) mask.geometry.size[a] = static_cast<int>(2 * (r + margin) / spacing[a]) + 1;
  Eigen::Vector3d middle;
  for (int a = 0; a < 3; ++a) middle[a] = (mask.geometry.size[a] - 1) / 2.0;
  mask.geometry.origin_mm = -(direction * spacing.cwiseProduct(middle));
  const Eigen::Affine3d world = mask.geometry.world_from_index();
  for (int k = 0; k < mask.geometry.size[2]; ++k)
    for (int j = 0; j < mask.geometry.size[1]; ++j)
      for (int i = 0; i < mask.geometry.size[0]; ++i)
        mask.voxels.push_back((world * Eigen::Vector3d(i, j, k)).norm() < r);
  return mask;
}

TEST(SurfaceError, OfASphereOnItsOwnMaskIsWithinHalfAVoxelAndGrowsWithAShift) {
  const Phantom phantom = make_phantom("sphere", {});
  const Mask truth = mask_of(phantom.labels, 1);
  double count = 0;
  for (const std::uint8_t voxel : truth.voxels) count += voxel;
  const double radius = std::cbrt(count * 0.75 / M_PI);  // voxels of 1 mm
  const SurfaceError error(truth);
  const SurfaceError::Values on = error.of(make_sphere({0, 0, 0}, radius, 4).positions);
  EXPECT_LT(on.mean_mm, 0.2);
  EXPECT_LT(on.max_mm, 0.5);
  EXPECT_LE(on.mean_mm, on.p95_mm);
  EXPECT_LE(on.p95_mm, on.max_mm);
  double before = on.mean_mm;
  for (const double shift : {1.0, 2.0, 4.0, 8.0}) {
    const SurfaceError::Values off = error.of(make_sphere({shift, 0, 0}, radius, 4).positions);
    EXPECT_GT(off.mean_mm, before);
    EXPECT_NEAR(off.max_mm, shift, 0.5);
    before = off.mean_mm;
  }
  // A radius larger or smaller by 3 mm gives the same error everywhere, up to the voxel steps.
  for (const double other : {radius + 3, radius - 3}) {
    const SurfaceError::Values off = error.of(make_sphere({0, 0, 0}, other, 4).positions);
    EXPECT_NEAR(off.mean_mm, 3, 0.4);
    EXPECT_NEAR(off.max_mm, 3, 0.5);
  }
}

TEST(SurfaceError, HoldsOnAnisotropicRotatedAndShearedGrids) {
  Eigen::Matrix3d sheared = Eigen::Matrix3d::Identity();
  sheared(0, 2) = 0.3;
  const Eigen::Matrix3d turned = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Eigen::Vector3d flat(0.7, 0.7, 3);
  for (const Eigen::Matrix3d& direction : {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), turned, sheared}) {
    const SurfaceError error(sphere_mask(15, flat, direction));
    const SurfaceError::Values on = error.of(make_sphere({0, 0, 0}, 15, 3).positions);
    EXPECT_LT(on.mean_mm, 0.5);
    EXPECT_LT(on.max_mm, 1.5);
    EXPECT_NEAR(error.of(make_sphere({0, 0, 0}, 19, 3).positions).mean_mm, 4, 0.5);
  }
}

TEST(SurfaceError, FarOutsideIsTheEuclideanDistance) {
  const SurfaceError error(sphere_mask(10, {1, 1, 1}));
  for (const Eigen::Vector3d& direction :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(1, 1, 1)})
    EXPECT_NEAR(error.at(200 * direction.normalized()), 190, 5);
  EXPECT_GE(error.at({200, 0, 0}), 190 - 0.5);
  EXPECT_NEAR(error.at({0, 0, 0}), 10, 0.7);
  EXPECT_TRUE(std::isinf(error.at({std::numeric_limits<double>::quiet_NaN(), 0, 0})));
}

TEST(SurfaceError, AReferenceAtTheImagesBorderEndsThere) {
  // If the whole grid is object, the surface consists of the grid's outer faces.
  Mask mask;
  mask.geometry.size = {10, 10, 10};
  mask.voxels.assign(1000, 1);
  const SurfaceError error(mask);
  EXPECT_NEAR(error.at({-0.5, 4.5, 4.5}), 0, 0.01);
  EXPECT_NEAR(error.at({9.5, 4.5, 4.5}), 0, 0.01);
  EXPECT_NEAR(error.at({1.5, 4.5, 4.5}), 2, 0.01);
}

TEST(SurfaceError, IsInfiniteForAnEmptyReferenceAndZeroWithoutVertices) {
  Mask empty = sphere_mask(5, {1, 1, 1});
  std::fill(empty.voxels.begin(), empty.voxels.end(), std::uint8_t{0});
  EXPECT_TRUE(std::isinf(SurfaceError(empty).of(make_sphere({0, 0, 0}, 5, 1).positions).mean_mm));
  EXPECT_EQ(SurfaceError(sphere_mask(5, {1, 1, 1})).of({}).max_mm, 0);
}

}  // namespace
}  // namespace simplexseg
