// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/error.h"
#include "image/rasterise.h"
#include "mesh/mesh_geometry.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {
namespace {

VolumeGeometry cubic_grid(int n) {
  VolumeGeometry g;
  g.size = {n, n, n};
  return g;
}

std::size_t count(const Mask& mask) {
  std::size_t sum = 0;
  for (auto v : mask.voxels) sum += v;
  return sum;
}

double volume_mm3(const Mask& mask) {
  return double(count(mask)) * std::abs(mask.geometry.world_from_index().linear().determinant());
}

std::uint8_t at(const Mask& mask, int i, int j, int k) {
  return mask.voxels[(std::size_t(k) * mask.geometry.size[1] + j) * mask.geometry.size[0] + i];
}

/// Box as a simplex mesh with eight vertices of three neighbours each. Corners are in the index space of a grid.
SimplexMesh box_mesh(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const VolumeGeometry& geometry) {
  SimplexMesh mesh;
  const bool mirrored = geometry.direction.determinant() < 0;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d index;
    for (int a = 0; a < 3; ++a) index[a] = corner >> a & 1 ? high[a] : low[a];
    mesh.positions.push_back((geometry.world_from_index() * index).cast<float>());
    const bool even = (std::popcount(unsigned(corner)) % 2 == 0) != mirrored;
    if (even)
      mesh.neighbours.push_back({corner ^ 1, corner ^ 4, corner ^ 2});
    else
      mesh.neighbours.push_back({corner ^ 1, corner ^ 2, corner ^ 4});
  }
  return mesh;
}

SimplexMesh joined(const SimplexMesh& a, const SimplexMesh& b) {
  SimplexMesh mesh = a;
  mesh.positions.insert(mesh.positions.end(), b.positions.begin(), b.positions.end());
  for (auto n : b.neighbours) {
    for (int& v : n) v += a.vertex_count();
    mesh.neighbours.push_back(n);
  }
  return mesh;
}

/// Mask of the box [low, high) of voxels.
Mask box_mask(const std::array<int, 3>& low, const std::array<int, 3>& high, const VolumeGeometry& geometry) {
  Mask mask{geometry, std::vector<std::uint8_t>(geometry.voxel_count())};
  for (int k = low[2]; k < high[2]; ++k)
    for (int j = low[1]; j < high[1]; ++j)
      for (int i = low[0]; i < high[0]; ++i)
        mask.voxels[(std::size_t(k) * geometry.size[1] + j) * geometry.size[0] + i] = 1;
  return mask;
}

/// Rotated, sheared, anisotropic grid far from the origin; optionally left-handed.
VolumeGeometry oblique_grid(int n, bool left_handed) {
  VolumeGeometry g = cubic_grid(n);
  g.spacing_mm = {0.8, 1.3, 1.1};
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
  shear(0, 2) = 0.2;
  g.direction = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix() * shear;
  if (left_handed) g.direction.col(0) *= -1;
  g.origin_mm = {-81.3, 40.7, 112.9};
  return g;
}

TEST(Rasterise, TheBoxOfTheTestsIsAValidMesh) {
  EXPECT_NO_THROW(validate(box_mesh({1, 1, 1}, {4, 5, 6}, cubic_grid(9))));
  EXPECT_NO_THROW(validate(box_mesh({1, 1, 1}, {4, 5, 6}, oblique_grid(9, true))));
}

TEST(Rasterise, FacesOnVoxelCentresTakeEachVoxelOnce) {
  const VolumeGeometry g = cubic_grid(12);
  EXPECT_EQ(rasterise(box_mesh({2, 3, 1}, {6, 7, 5}, g), g).voxels, box_mask({2, 3, 1}, {6, 7, 5}, g).voxels);
  EXPECT_EQ(rasterise(box_mesh({1.5, 2.5, 0.5}, {5.5, 6.5, 4.5}, g), g).voxels,
            box_mask({2, 3, 1}, {6, 7, 5}, g).voxels);
}

TEST(Rasterise, TouchingBoxesShareNothingAndLeaveNoGap) {
  for (const VolumeGeometry& g : {cubic_grid(24), oblique_grid(24, false), oblique_grid(24, true)}) {
    const Mask whole = rasterise(box_mesh({2, 3, 4}, {20, 21, 19}, g), g);
    EXPECT_EQ(whole.voxels, box_mask({2, 3, 4}, {20, 21, 19}, g).voxels);
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::Vector3d low_end(20, 21, 19), high_start(2, 3, 4);
      low_end[axis] = high_start[axis] = 11;
      const Mask a = rasterise(box_mesh({2, 3, 4}, low_end, g), g);
      const Mask b = rasterise(box_mesh(high_start, {20, 21, 19}, g), g);
      for (std::size_t v = 0; v < whole.voxels.size(); ++v)
        ASSERT_EQ(a.voxels[v] + b.voxels[v], whole.voxels[v]) << axis;
    }
  }
}

TEST(Rasterise, SpheresHaveTheVolumeOfTheirMesh) {
  for (const Eigen::Vector3d& centre :
       {Eigen::Vector3d(32, 32, 32), Eigen::Vector3d(31.5, 31.5, 31.5), Eigen::Vector3d(30.123, 33.456, 31.789)}) {
    for (double radius : {14.0, 25.0}) {
      const SimplexMesh mesh = make_sphere(centre, radius, 4);
      const Mask mask = rasterise(mesh, cubic_grid(64));
      EXPECT_NEAR(volume_mm3(mask) / measure(mesh).volume_mm3, 1, 0.01) << radius;
      EXPECT_EQ(at(mask, 32, 32, 32), 1);
    }
  }
  const SimplexMesh mesh = make_ellipsoid({32, 30, 33}, {20, 9, 14}, 4);
  EXPECT_NEAR(volume_mm3(rasterise(mesh, cubic_grid(64))) / measure(mesh).volume_mm3, 1, 0.01);
}

// Compares each voxel with its distance to the centre in world coordinates, independent of the grid.
TEST(Rasterise, AnyDirectionMatrixGivesTheSameSolid) {
  VolumeGeometry straight = cubic_grid(50), flipped = straight, turned = straight;
  flipped.direction.col(0) *= -1;
  flipped.origin_mm[0] = 49;
  turned.direction << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  for (const VolumeGeometry& g : {straight, flipped, turned, oblique_grid(50, false), oblique_grid(50, true)}) {
    const Eigen::Vector3d centre = g.centre_mm() + Eigen::Vector3d(0.31, -0.17, 0.23);
    const double radius = 14;
    const SimplexMesh mesh = make_sphere(centre, radius, 4);
    const Mask mask = rasterise(mesh, g);
    int wrong = 0;
    for (int k = 0; k < 50; ++k)
      for (int j = 0; j < 50; ++j)
        for (int i = 0; i < 50; ++i) {
          const double d = (g.world_from_index() * Eigen::Vector3d(i, j, k) - centre).norm();
          // The facets lie up to 0.1 mm inside the sphere.
          if (d < radius - 0.1) wrong += at(mask, i, j, k) != 1;
          if (d > radius + 1e-3) wrong += at(mask, i, j, k) != 0;
        }
    EXPECT_EQ(wrong, 0);
    EXPECT_NEAR(volume_mm3(mask) / measure(mesh).volume_mm3, 1, 0.01);
  }
}

TEST(Rasterise, LinesAlongOtherAxesGiveTheSameVoxels) {
  VolumeGeometry straight = cubic_grid(40), turned = straight;
  turned.direction << 0, 0, 1, 1, 0, 0, 0, 1, 0;  // its i axis is y, its j axis z, its k axis x
  const SimplexMesh mesh = make_ellipsoid({19.37, 20.71, 18.93}, {15.1, 8.2, 11.3}, 3);
  const Mask a = rasterise(mesh, straight), b = rasterise(mesh, turned);
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) ASSERT_EQ(at(a, x, y, z), at(b, y, z, x));
}

TEST(Rasterise, OverlapsOfAFoldedMeshStayFilled) {
  const VolumeGeometry g = cubic_grid(16);
  const Mask mask = rasterise(joined(box_mesh({2, 2, 2}, {9, 9, 9}, g), box_mesh({5, 5, 5}, {13, 13, 13}, g)), g);
  Mask expected = box_mask({2, 2, 2}, {9, 9, 9}, g);
  const Mask second = box_mask({5, 5, 5}, {13, 13, 13}, g);
  for (std::size_t v = 0; v < second.voxels.size(); ++v) expected.voxels[v] |= second.voxels[v];
  EXPECT_EQ(mask.voxels, expected.voxels);
  // Pushing the lid through the bottom reverses the orientation of the box, which stays filled.
  SimplexMesh inverted = box_mesh({2, 2, 8}, {9, 9, 12}, g);
  for (auto& p : inverted.positions) p[2] = p[2] > 10 ? 4 : p[2];
  EXPECT_EQ(rasterise(inverted, g).voxels, box_mask({2, 2, 4}, {9, 9, 8}, g).voxels);
}

// Vertices on voxel centres, collapsed triangles and folds: nothing may leak along a row.
TEST(Rasterise, TangledMeshesNeverLeak) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 60; ++trial) {
    SimplexMesh mesh = make_sphere({20, 20, 20}, 9, trial % 4);
    Eigen::Array3f low = mesh.positions[0], high = low;
    for (auto& p : mesh.positions) {
      for (int a = 0; a < 3; ++a) {
        p[a] += float(random() % 2000) / 1000 * float(trial % 5) - float(trial % 5);
        if (trial % 3 != 0) p[a] = std::round(p[a] * float(trial % 3)) / float(trial % 3);
      }
      low = low.min(p.array());
      high = high.max(p.array());
    }
    const Mask mask = rasterise(mesh, cubic_grid(40));
    EXPECT_GT(count(mask), 1000u);
    for (int k = 0; k < 40; ++k)
      for (int j = 0; j < 40; ++j)
        for (int i = 0; i < 40; ++i)
          if (at(mask, i, j, k)) {
            const Eigen::Array3f index(i, j, k);
            ASSERT_TRUE((index >= low - 1e-3f).all() && (index <= high + 1e-3f).all()) << trial;
          }
  }
}

TEST(Rasterise, PartsOutsideTheGridAreCutOff) {
  const VolumeGeometry g = cubic_grid(10);
  EXPECT_EQ(count(rasterise(make_sphere({4, 4, 4}, 500, 3), g)), 1000u);
  EXPECT_EQ(count(rasterise(make_sphere({400, 4, 4}, 50, 3), g)), 0u);
  EXPECT_EQ(count(rasterise(make_sphere({4, -400, 4}, 50, 3), g)), 0u);
  EXPECT_EQ(count(rasterise(make_sphere({4, 4, 4e30}, 50, 1), g)), 0u);
  EXPECT_EQ(rasterise(box_mesh({-5, 3, -7.5}, {4, 50, 5.5}, g), g).voxels, box_mask({0, 3, 0}, {4, 10, 6}, g).voxels);
  EXPECT_EQ(count(rasterise(SimplexMesh(), g)), 0u);
}

TEST(Rasterise, ASingleSliceIsEnough) {
  VolumeGeometry g = cubic_grid(30);
  g.size[2] = 1;
  const Mask mask = rasterise(make_sphere({15.3, 14.8, 0.1}, 10, 4), g);
  EXPECT_NEAR(double(count(mask)), std::numbers::pi * 100, 6);
}

TEST(Fractions, OfABoxAreThoseOfItsFaces) {
  VolumeGeometry g = cubic_grid(12);
  g.spacing_mm = {0.7, 1.3, 2};
  g.origin_mm = {-20, 5, 3};
  g.direction = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, -2, 1).normalized()).toRotationMatrix();
  // Faces at any place along i, and at quarters of voxels along j and k, which the lines separate.
  const Eigen::Vector3d low(2.1, 3.25, 4), high(6.83, 8.5, 9.75);
  const std::vector<float> fractions = inside_fractions(box_mesh(low, high, g), g);
  const auto overlap = [&](int axis, int at) {
    return std::clamp(std::min(high[axis], at + 0.5) - std::max(low[axis], at - 0.5), 0.0, 1.0);
  };
  std::size_t v = 0;
  for (int k = 0; k < 12; ++k)
    for (int j = 0; j < 12; ++j)
      for (int i = 0; i < 12; ++i, ++v)
        ASSERT_NEAR(fractions[v], overlap(0, i) * overlap(1, j) * overlap(2, k), 1e-4) << i << " " << j << " " << k;
}

TEST(Fractions, AddUpToTheVolumeOfTheMeshOnAnyGrid) {
  const SimplexMesh sphere = make_sphere({15.3, 14.8, 15.1}, 10, 4);
  const double volume = measure(sphere).volume_mm3;
  for (const double spacing : {0.8, 2.0, 5.0, 15.0}) {
    VolumeGeometry g = cubic_grid(static_cast<int>(std::ceil(32 / spacing)));
    g.spacing_mm.setConstant(spacing);
    const std::vector<float> fractions = inside_fractions(sphere, g);
    double sum = 0;
    for (const float f : fractions) sum += f;
    const double centres = volume_mm3(rasterise(sphere, g));
    EXPECT_NEAR(sum * std::pow(spacing, 3) / volume, 1, spacing > 10 ? 0.02 : 0.005) << spacing;
    EXPECT_LE(std::abs(sum * std::pow(spacing, 3) - volume), std::abs(centres - volume) + 1e-3 * volume) << spacing;
  }
  EXPECT_EQ(inside_fractions(make_sphere({4, 4, 4}, 500, 3), cubic_grid(5)), std::vector<float>(125, 1.0f));
}

TEST(Rasterise, PositionsThatAreNotFiniteAreRefused) {
  SimplexMesh mesh = make_sphere({5, 5, 5}, 3, 0);
  mesh.positions[7][1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(rasterise(mesh, cubic_grid(10)), Error);
  VolumeGeometry bad = cubic_grid(10);
  bad.spacing_mm[0] = 0;
  EXPECT_THROW(rasterise(make_sphere({5, 5, 5}, 3, 0), bad), Error);
}

}  // namespace
}  // namespace simplexseg
