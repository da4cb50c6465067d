// SPDX-License-Identifier: Apache-2.0
#include "image/volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/error.h"

namespace simplexseg {
namespace {

VolumeGeometry oblique_geometry() {
  VolumeGeometry g;
  g.size = {4, 5, 6};
  g.spacing_mm = {0.5, 1.5, 2.5};
  g.origin_mm = {-10, 20, 30};
  // Rotated, sheared and left-handed.
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
  shear(1, 2) = 0.25;
  g.direction = Eigen::AngleAxisd(0.6, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix() * shear *
                Eigen::Vector3d(-1, 1, 1).asDiagonal();
  return g;
}

std::string message_of(const VolumeGeometry& geometry) {
  try {
    geometry.validate("scan.nii");
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(VolumeGeometry, WorldFromIndexFollowsItk) {
  const VolumeGeometry g = oblique_geometry();
  const Eigen::Vector3d index(1, 2, 3), step(0.5, 3, 7.5);
  EXPECT_LT((g.world_from_index() * index - (g.origin_mm + g.direction * step)).norm(), 1e-12);
  EXPECT_LT((g.index_from_world() * (g.world_from_index() * index) - index).norm(), 1e-12);
  EXPECT_EQ(g.voxel_count(), 120u);
  EXPECT_LT((g.index_from_world() * g.centre_mm() - Eigen::Vector3d(1.5, 2, 2.5)).norm(), 1e-12);
}

TEST(VolumeGeometry, ContainsReachesToTheOuterFaces) {
  const VolumeGeometry g = oblique_geometry();
  const Eigen::Affine3d world = g.world_from_index();
  EXPECT_TRUE(g.contains(g.centre_mm()));
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3d low(1, 1, 1), high(1, 1, 1);
    low[axis] = -0.49;
    high[axis] = g.size[axis] - 0.51;
    EXPECT_TRUE(g.contains(world * low));
    EXPECT_TRUE(g.contains(world * high));
    low[axis] = -0.51;
    high[axis] = g.size[axis] - 0.49;
    EXPECT_FALSE(g.contains(world * low));
    EXPECT_FALSE(g.contains(world * high));
  }
  EXPECT_FALSE(g.contains(Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN())));
}

TEST(VolumeGeometry, SameGridToleratesOnlyRounding) {
  const VolumeGeometry g = oblique_geometry();
  VolumeGeometry other = g;
  EXPECT_TRUE(g.same_grid(other));
  other.origin_mm[0] += 1e-4;
  other.spacing_mm[1] *= 1 + 1e-6;
  EXPECT_TRUE(g.same_grid(other));
  EXPECT_FALSE(g.same_grid(other, 1e-7));
  other = g;
  other.spacing_mm[2] *= 1.01;  // 0.05 voxel at the far corner
  EXPECT_FALSE(g.same_grid(other));
  other = g;
  other.size[2] += 1;
  EXPECT_FALSE(g.same_grid(other));
  other = g;
  other.direction.col(0) *= -1;
  EXPECT_FALSE(g.same_grid(other));
  other = g;
  other.origin_mm[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(g.same_grid(other));
}

TEST(VolumeGeometry, ANegativeStepReversesTheAxis) {
  VolumeGeometry g = oblique_geometry();
  const Eigen::Affine3d before = g.world_from_index();
  g.set_step(1, -g.spacing_mm[1]);
  EXPECT_EQ(g.spacing_mm[1], 1.5);
  EXPECT_TRUE((g.world_from_index() * Eigen::Vector3d(1, -2, 3)).isApprox(before * Eigen::Vector3d(1, 2, 3)));
  g.set_step(0, 4);
  EXPECT_EQ(g.spacing_mm[0], 4);
  EXPECT_EQ(g.direction.col(0), oblique_geometry().direction.col(0));
}

TEST(VolumeGeometry, ValidateNamesTheVolumeInOneLine) {
  EXPECT_EQ(message_of(oblique_geometry()), "");
  std::vector<VolumeGeometry> bad(12, oblique_geometry());
  bad[0].size[1] = 0;
  bad[1].size = {2000000000, 2000000000, 2000000000};
  bad[2].spacing_mm[0] = 0;
  bad[3].spacing_mm[2] = -1;
  bad[4].spacing_mm[1] = std::numeric_limits<double>::infinity();
  bad[5].direction.col(2) = bad[5].direction.col(0);
  bad[6].direction(0, 0) = std::numeric_limits<double>::quiet_NaN();
  bad[7].origin_mm[0] = std::numeric_limits<double>::quiet_NaN();
  bad[8].spacing_mm[0] = 1e308;
  bad[9].spacing_mm[1] = 1e-300;
  bad[10].origin_mm[2] = -1e300;
  bad[11].direction(1, 1) = 1e200;
  for (std::size_t b = 0; b < bad.size(); ++b) {
    const std::string message = message_of(bad[b]);
    EXPECT_TRUE(message.starts_with("scan.nii: ")) << b << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_NE(message_of(bad[0]).find("4 x 0 x 6"), std::string::npos);
  EXPECT_THROW(Volume(bad[2], VoxelType::UInt8), Error);
}

TEST(VolumeGeometry, ASmallScaleOfTheDirectionIsNotSingular) {
  VolumeGeometry g = oblique_geometry();
  g.direction *= 1e-4;
  EXPECT_NO_THROW(g.validate("v"));
}

TEST(Volume, EveryTypeKeepsItsExtremes) {
  VolumeGeometry g;
  g.size = {3, 2, 2};
  for (VoxelType type : {VoxelType::Int8, VoxelType::UInt8, VoxelType::Int16, VoxelType::UInt16, VoxelType::Int32,
                         VoxelType::UInt32, VoxelType::Float32, VoxelType::Float64}) {
    Volume volume(g, type);
    EXPECT_EQ(volume.bytes(), 12 * bytes_per_voxel(type));
    EXPECT_EQ(volume.range().min, 0);
    EXPECT_EQ(volume.range().max, 0);
    visit_voxel_type(type, [&]<class T>(std::type_identity<T>) {
      EXPECT_EQ(voxel_type_of<T>(), type);
      const T low = std::numeric_limits<T>::lowest(), high = std::numeric_limits<T>::max();
      volume.voxels<T>()[volume.offset(2, 0, 1)] = low;
      volume.voxels<T>()[volume.offset(1, 1, 0)] = high;
      EXPECT_EQ(volume.value(2, 0, 1), static_cast<double>(low)) << to_string(type);
      EXPECT_EQ(volume.value(1, 1, 0), static_cast<double>(high)) << to_string(type);
      EXPECT_EQ(volume.range().min, static_cast<double>(low)) << to_string(type);
      EXPECT_EQ(volume.range().max, static_cast<double>(high)) << to_string(type);
    });
  }
  EXPECT_STREQ(to_string(VoxelType::Int8), "int8");
  EXPECT_STREQ(to_string(VoxelType::UInt16), "uint16");
  EXPECT_STREQ(to_string(VoxelType::Float64), "float64");
}

TEST(Volume, RangeIgnoresValuesThatAreNotFinite) {
  VolumeGeometry g;
  g.size = {7, 1, 1};
  Volume volume(g, VoxelType::Float32);
  const auto voxels = volume.voxels<float>();
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  std::fill(voxels.begin(), voxels.end(), nan);
  EXPECT_EQ(volume.range().min, 0);
  EXPECT_EQ(volume.range().max, 0);
  voxels[2] = -inf;
  voxels[3] = inf;
  voxels[5] = 4;
  voxels[6] = 7;
  EXPECT_EQ(volume.range().min, 4);
  EXPECT_EQ(volume.range().max, 7);
  EXPECT_EQ(Volume().range().max, 0);
}

TEST(Volume, CopiesShareTheirVoxels) {
  VolumeGeometry g;
  g.size = {2, 2, 2};
  Volume volume(g, VoxelType::Int16);
  const Volume copy = volume;
  volume.voxels<std::int16_t>()[3] = -7;
  EXPECT_EQ(copy.value(1, 1, 0), -7);
  EXPECT_EQ(copy.data(), static_cast<const Volume&>(volume).data());
  EXPECT_TRUE(Volume().empty());
  EXPECT_FALSE(copy.empty());
}

TEST(Volume, SamplingReproducesALinearFieldInWorldCoordinates) {
  const VolumeGeometry g = oblique_geometry();
  Volume volume(g, VoxelType::Float64);
  const Eigen::Vector3d slope(1.5, -2, 0.25);
  const auto voxels = volume.voxels<double>();
  for (int k = 0; k < 6; ++k)
    for (int j = 0; j < 5; ++j)
      for (int i = 0; i < 4; ++i)
        voxels[volume.offset(i, j, k)] = slope.dot(g.world_from_index() * Eigen::Vector3d(i, j, k));
  for (const Eigen::Vector3d& index : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(3, 4, 5),
                                       Eigen::Vector3d(0.3, 3.9, 2.5), Eigen::Vector3d(2.75, 0.1, 4.99)}) {
    const Eigen::Vector3d world = g.world_from_index() * index;
    EXPECT_NEAR(volume.sample(world), slope.dot(world), 1e-10);
  }
  // Positions outside get the nearest voxel.
  EXPECT_NEAR(volume.sample(g.world_from_index() * Eigen::Vector3d(-5, 2, 99)), volume.value(0, 2, 5), 1e-10);
  EXPECT_TRUE(std::isfinite(volume.sample(Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()))));
}

TEST(Volume, SamplingOnAVoxelIgnoresItsNeighbours) {
  VolumeGeometry g;
  g.size = {3, 1, 1};
  Volume volume(g, VoxelType::Float32);
  volume.voxels<float>()[0] = 5;
  volume.voxels<float>()[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(volume.sample({0, 0, 0}), 5);
  EXPECT_TRUE(std::isnan(volume.sample({0.5, 0, 0})));
}

}  // namespace
}  // namespace simplexseg
