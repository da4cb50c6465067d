// SPDX-License-Identifier: Apache-2.0
#include "image/transform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "core/error.h"

namespace simplexseg {
namespace {

/// Rigid map: rotation by `degrees` about a slanted axis, and a translation.
Eigen::Affine3d rigid_map(double degrees) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.5).normalized();
  return Eigen::Translation3d(12, -7, 3) * Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis);
}

VolumeGeometry turned_grid() {
  VolumeGeometry grid{.size = {20, 16, 12}, .spacing_mm = {1.5, 2, 2.5}, .origin_mm = {-10, 4, 7}};
  grid.direction = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return grid;
}

/// Field with smooth displacements of up to `amplitude` mm.
DisplacementField smooth_field(double amplitude) {
  const VolumeGeometry grid = turned_grid();
  std::vector<Eigen::Vector3f> vectors;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Eigen::Vector3d wave(std::sin(0.3 * j), std::cos(0.25 * k), std::sin(0.2 * i + 0.1 * j));
        vectors.push_back((amplitude * wave).cast<float>());
      }
    }
  }
  return {grid, vectors};
}

TEST(Transform, ConsecutiveAffineMapsBecomeOneAndTheInverseUndoesThem) {
  Transform transform(rigid_map(20));
  Eigen::Affine3d stretch = Eigen::Affine3d::Identity();
  stretch.linear() = Eigen::Vector3d(1.1, 0.9, 1.3).asDiagonal();
  transform.append(stretch);
  EXPECT_EQ(transform.steps().size(), 1u);
  const Eigen::Vector3d point(3, 40, -8);
  EXPECT_LT((transform(point) - stretch * (rigid_map(20) * point)).norm(), 1e-12);
  const std::optional<Eigen::Vector3d> back = transform.inverse(transform(point));
  ASSERT_TRUE(back);
  EXPECT_LT((*back - point).norm(), 1e-9);
}

TEST(Transform, AFieldActsBeforeTheAffineMapThatFollowsIt) {
  const DisplacementField field = smooth_field(2);
  Transform transform;
  transform.append(field);
  transform.append(rigid_map(10));
  const Eigen::Vector3d point = turned_grid().world_from_index() * Eigen::Vector3d(7.3, 6.1, 4.8);
  EXPECT_LT((transform(point) - rigid_map(10) * (point + field.at(point))).norm(), 1e-12);
  EXPECT_FALSE(transform.affine());
  const std::optional<Eigen::Vector3d> back = transform.inverse(transform(point), 1e-9);
  ASSERT_TRUE(back);
  EXPECT_LT((*back - point).norm(), 1e-6);
}

TEST(Transform, AFieldHasItsVectorsAtVoxelsAndNoneOutside) {
  const DisplacementField field = smooth_field(2);
  const VolumeGeometry grid = turned_grid();
  const Eigen::Affine3d world = grid.world_from_index();
  const std::size_t offset = (3 * 16 + 5) * 20 + 11;
  EXPECT_LT((field.at(world * Eigen::Vector3d(11, 5, 3)) - field.vectors()[offset].cast<double>()).norm(), 1e-6);
  EXPECT_GT(field.at(world * Eigen::Vector3d(-0.4, 5, 3)).norm(), 0);
  EXPECT_EQ(field.at(world * Eigen::Vector3d(-0.6, 5, 3)).norm(), 0);
  EXPECT_EQ(field.at(world * Eigen::Vector3d(5, 5, 11.6)).norm(), 0);
  EXPECT_THROW(DisplacementField(grid, std::vector<Eigen::Vector3f>(7)), Error);
}

TEST(Transform, TheJacobianIsTheDeterminantAndFindsFolds) {
  Eigen::Affine3d stretch = rigid_map(30);
  stretch.linear() *= 1.2;
  const JacobianRange affine = jacobian_range(Transform(stretch), turned_grid());
  EXPECT_NEAR(affine.min, 1.2 * 1.2 * 1.2, 1e-9);
  EXPECT_EQ(affine.min, affine.max);
  EXPECT_EQ(affine.folded_share, 0);
  Transform smooth;
  smooth.append(smooth_field(0.5));
  const JacobianRange gentle = jacobian_range(smooth, turned_grid());
  EXPECT_GT(gentle.min, 0.5);
  EXPECT_LT(gentle.max, 1.5);
  EXPECT_GT(gentle.max, gentle.min);
  Transform folded;
  folded.append(smooth_field(40));
  EXPECT_GT(jacobian_range(folded, turned_grid()).folded_share, 0.1);
}

TEST(Transform, TheInverseOfAFoldedFieldIsRefused) {
  Transform folded;
  folded.append(smooth_field(40));
  int refused = 0;
  for (int i = 2; i < 18; ++i)
    refused += !folded.inverse(turned_grid().world_from_index() * Eigen::Vector3d(i, 8, 6), 1e-6);
  EXPECT_GT(refused, 0);
}

TEST(Transform, LandmarksGiveTheRigidMapAndRefuseALine) {
  const std::vector<Eigen::Vector3d> fixed{{0, 0, 0}, {50, 2, 1}, {3, 60, -4}, {10, 10, 70}};
  std::vector<Eigen::Vector3d> moving;
  for (const Eigen::Vector3d& point : fixed) moving.push_back(rigid_map(170) * point);
  EXPECT_TRUE(rigid_from_landmarks(fixed, moving).isApprox(rigid_map(170), 1e-9));
  const std::vector<Eigen::Vector3d> line{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  EXPECT_THROW(rigid_from_landmarks(line, line), Error);
  EXPECT_THROW(rigid_from_landmarks({fixed[0], fixed[1]}, {moving[0], moving[1]}), Error);
  EXPECT_THROW(rigid_from_landmarks(fixed, {moving[0]}), Error);
}

TEST(Transform, ResamplingReadsTheMovingImageAtTheMappedPoint) {
  VolumeGeometry grid{.size = {12, 12, 12}};
  Volume moving(grid, VoxelType::Int16);
  for (int k = 0; k < 12; ++k)
    for (int j = 0; j < 12; ++j)
      for (int i = 0; i < 12; ++i) moving.voxels<std::int16_t>()[moving.offset(i, j, k)] = std::int16_t(10 * i + j);
  const Transform shift(Eigen::Affine3d(Eigen::Translation3d(2.3, 0, 0)));
  const Volume result = resample_through(moving, grid, shift, 2);
  EXPECT_EQ(result.value(3, 4, 5), 57);  // 10 * 5.3 + 4
  EXPECT_EQ(result.value(10, 4, 5), 0);  // outside
}

}  // namespace
}  // namespace simplexseg
