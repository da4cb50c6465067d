// SPDX-License-Identifier: Apache-2.0
#include "image/surface_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "image/metrics.h"
#include "support/empty_mask.h"

namespace simplexseg {
namespace {

template <class F>
void fill(Mask& mask, F&& inside) {
  std::size_t v = 0;
  for (int k = 0; k < mask.geometry.size[2]; ++k)
    for (int j = 0; j < mask.geometry.size[1]; ++j)
      for (int i = 0; i < mask.geometry.size[0]; ++i) mask.voxels[v++] = inside(i, j, k);
}

/// Values from the tests of google-deepmind/surface-distance (surface_distance_test.py, 3D).
TEST(SurfaceMetrics, PublishedValues) {
  Mask a = empty_mask({128, 128, 128}, {3, 2, 1}), b = a;
  fill(a, [](int i, int j, int k) { return i == 50 && j == 60 && k == 70; });
  fill(b, [](int i, int j, int k) { return i == 50 && j == 60 && k == 72; });
  const SurfaceAgreement points = compare_surfaces(a, b, 1);
  EXPECT_NEAR(points.asd_reference_mm, 1.5, 1e-6);
  EXPECT_NEAR(points.asd_test_mm, 1.5, 1e-6);
  EXPECT_NEAR(points.hd_mm, 2, 1e-6);
  EXPECT_NEAR(points.hd95_mm, 2, 1e-6);
  EXPECT_NEAR(points.overlap_reference, 0.5, 1e-6);
  EXPECT_NEAR(points.overlap_test, 0.5, 1e-6);
  EXPECT_NEAR(points.surface_dice, 0.5, 1e-6);

  a = b = empty_mask({100, 100, 100}, {2, 1, 1});
  fill(a, [](int i, int, int) { return i < 50; });
  fill(b, [](int i, int, int) { return i < 51; });
  const SurfaceAgreement halves = compare_surfaces(a, b, 1);
  EXPECT_NEAR(halves.asd_reference_mm, 0.322, 5e-4);
  EXPECT_NEAR(halves.asd_test_mm, 0.339, 5e-4);
  EXPECT_NEAR(halves.hd_mm, 2, 1e-6);
  EXPECT_NEAR(halves.hd95_mm, 2, 1e-6);
  EXPECT_NEAR(halves.overlap_reference, 0.842, 5e-4);
  EXPECT_NEAR(halves.overlap_test, 0.830, 5e-4);
  EXPECT_NEAR(halves.surface_dice, 0.836, 5e-4);
}

/// Areas of the marching cubes cases in the unit cube, with vertices at the midpoints of edges.
TEST(SurfaceMetrics, AreasOfCells) {
  const auto areas = surface_areas(Eigen::Matrix3d::Identity());
  const double triangle = std::sqrt(3) / 8, quad = std::sqrt(2) / 2;
  EXPECT_EQ(areas[0], 0);
  EXPECT_EQ(areas[255], 0);
  EXPECT_NEAR(areas[0b1], triangle, 1e-12);
  EXPECT_NEAR(areas[0b11], quad, 1e-12);                 // an edge
  EXPECT_NEAR(areas[0b1001], 2 * triangle, 1e-12);       // the diagonal of a face
  EXPECT_NEAR(areas[0b10000001], 2 * triangle, 1e-12);   // the diagonal of the cube
  EXPECT_NEAR(areas[0b111], 0.5 + 3 * triangle, 1e-12);  // a pentagon
  EXPECT_NEAR(areas[0b1111], 1, 1e-12);                  // a face
  EXPECT_NEAR(areas[0b10111], 6 * triangle, 1e-12);      // a corner and its neighbours: a plane hexagon
  EXPECT_NEAR(areas[0b1101001], 4 * triangle, 1e-12);    // four corners, no two adjacent
  for (unsigned code = 0; code < 256; ++code) EXPECT_NEAR(areas[code], areas[255 - code], 1e-12) << code;
  Eigen::Matrix3d sheared = Eigen::Vector3d(2, 3, 5).asDiagonal();
  sheared(0, 1) = 1.5;
  // The face x = 1/2 of the cell: edges along y and z.
  EXPECT_NEAR(surface_areas(sheared)[0b01010101], sheared.col(1).cross(sheared.col(2)).norm(), 1e-12);
}

/// Concentric balls are 6 mm apart everywhere for any voxel size.
TEST(SurfaceMetrics, VoxelSizeDoesNotWeight) {
  const auto ball = [](double spacing_k, double radius) {
    Mask mask = empty_mask({48, 48, static_cast<int>(48 / spacing_k)}, {1, 1, spacing_k});
    fill(mask,
         [&](int i, int j, int k) { return (Eigen::Vector3d(i - 24, j - 24, k * spacing_k - 24)).norm() < radius; });
    return mask;
  };
  for (const double spacing : {1.0, 2.0}) {
    const Mask large = ball(spacing, 16), small = ball(spacing, 10);
    const SurfaceAgreement apart = compare_surfaces(large, small, 4), within = compare_surfaces(large, small, 9);
    // Both surfaces are represented by cell centres: distances are off by up to half a voxel diagonal.
    EXPECT_NEAR(apart.asd_reference_mm, 6, 0.5 * std::sqrt(2 + spacing * spacing)) << spacing;
    EXPECT_NEAR(apart.asd_test_mm, 6, 0.5 * std::sqrt(2 + spacing * spacing)) << spacing;
    EXPECT_EQ(apart.surface_dice, 0) << spacing;
    EXPECT_EQ(within.surface_dice, 1) << spacing;
    EXPECT_NEAR(apart.area_reference_mm2, 4 * M_PI * 16 * 16, 0.12 * 4 * M_PI * 16 * 16) << spacing;
  }
}

TEST(SurfaceMetrics, EmptyAndEqualMasks) {
  const Mask none = empty_mask({5, 5, 5});
  Mask one = none;
  fill(one, [](int i, int j, int k) { return i == 2 && j == 2 && k == 2; });
  const SurfaceAgreement both = compare_surfaces(none, none, 1), missing = compare_surfaces(one, none, 1),
                         same = compare_surfaces(one, one, 0);
  EXPECT_EQ(both.surface_dice, 1);
  EXPECT_EQ(both.hd_mm, 0);
  EXPECT_EQ(missing.hd95_mm, std::numeric_limits<double>::infinity());
  EXPECT_EQ(missing.surface_dice, 0);
  EXPECT_NEAR(missing.area_reference_mm2, std::sqrt(3), 1e-12);
  EXPECT_EQ(missing.area_test_mm2, 0);
  EXPECT_EQ(same.surface_dice, 1);
  EXPECT_EQ(same.assd_mm, 0);
  EXPECT_THROW(compare_surfaces(one, empty_mask({5, 5, 4}), 1), Error);
  EXPECT_THROW(compare_surfaces(one, one, -1), Error);
  EXPECT_THROW(compare_surfaces(one, one, std::numeric_limits<double>::infinity()), Error);
}

/// The surface of a mask that fills the image is closed at the border.
TEST(SurfaceMetrics, TheBorderOfTheImageIsASurface) {
  Mask all = empty_mask({3, 4, 5});
  fill(all, [](int, int, int) { return true; });
  // Six faces through the voxel midpoints, half a voxel outside, with cut edges and corners.
  const double faces = 2 * (2 * 3 + 3 * 4 + 2 * 4), edges = 4 * (2 + 3 + 4) * std::sqrt(2) / 2,
               corners = 8 * std::sqrt(3) / 8;
  EXPECT_NEAR(compare_surfaces(all, all, 1).area_reference_mm2, faces + edges + corners, 1e-9);
}

}  // namespace
}  // namespace simplexseg
