// SPDX-License-Identifier: Apache-2.0
#include "image/measurement.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

namespace simplexseg {
namespace {

constexpr auto kRuler = MeasurementKind::Ruler;
constexpr auto kAngle = MeasurementKind::Angle;
constexpr auto kEllipse = MeasurementKind::Ellipse;

Volume random_volume(std::mt19937& random, VolumeGeometry geometry) {
  Volume volume(std::move(geometry), VoxelType::Int16);
  for (std::int16_t& voxel : volume.voxels<std::int16_t>())
    voxel = static_cast<std::int16_t>(std::uniform_int_distribution<int>(-1000, 2000)(random));
  return volume;
}

/// Statistics of all voxels that the definition selects, in two passes.
std::optional<EllipseIntensities> reference_intensities(const Measurement& ellipse, const Volume& volume) {
  const VolumeGeometry& g = volume.geometry();
  const Eigen::Affine3d world = g.world_from_index();
  const Eigen::Vector3d a = ellipse.points_mm[1] - ellipse.points_mm[0],
                        b = ellipse.points_mm[2] - ellipse.points_mm[0], n = a.cross(b).normalized();
  std::vector<double> values;
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i) {
        const Eigen::Vector3d p = world * Eigen::Vector3d(i, j, k) - ellipse.points_mm[0];
        double low = INFINITY, high = -INFINITY;  // heights of the corners of the voxel
        for (int c = 0; c < 8; ++c) {
          const Eigen::Vector3d corner(c & 1, c >> 1 & 1, c >> 2 & 1);
          const double height = n.dot(p + world.linear() * (corner - Eigen::Vector3d::Constant(0.5)));
          low = std::min(low, height), high = std::max(high, height);
        }
        if (low >= 0 || high <= 0) continue;
        if (std::pow(p.dot(a) / a.squaredNorm(), 2) + std::pow(p.dot(b) / b.squaredNorm(), 2) <= 1)
          values.push_back(volume.value(i, j, k));
      }
  if (values.empty()) return std::nullopt;
  EllipseIntensities result{values.size(), 0, 0, values[0], values[0]};
  for (const double v : values) result.mean += v / static_cast<double>(values.size());
  for (const double v : values) {
    result.deviation += (v - result.mean) * (v - result.mean) / static_cast<double>(values.size());
    result.minimum = std::min(result.minimum, v), result.maximum = std::max(result.maximum, v);
  }
  result.deviation = std::sqrt(result.deviation);
  return result;
}

TEST(Measurement, LengthAngleAndArea) {
  EXPECT_DOUBLE_EQ(ruler_length_mm({0, kRuler, {{1, 2, 3}, {4, 6, 15}}, ""}), 13);
  EXPECT_DOUBLE_EQ(angle_degrees({0, kAngle, {{5, 1, 1}, {1, 1, 1}, {1, 1, 9}}, ""}), 90);
  EXPECT_DOUBLE_EQ(angle_degrees({0, kAngle, {{5, 1, 1}, {1, 1, 1}, {-7, 1, 1}}, ""}), 180);
  EXPECT_NEAR(angle_degrees({0, kAngle, {{1, 0, 0}, {0, 0, 0}, {1, 1e-9, 0}}, ""}), 1e-9 * 180 / std::numbers::pi,
              1e-20);
  EXPECT_DOUBLE_EQ(ellipse_area_mm2({0, kEllipse, {{0, 0, 0}, {3, 0, 0}, {0, 0, 2}}, ""}), 6 * std::numbers::pi);
}

TEST(Measurement, DefectsAreNamed) {
  EXPECT_FALSE(defect_of(kRuler, {{0, 0, 0}, {1, 0, 0}}));
  EXPECT_TRUE(defect_of(kRuler, {{0, 0, 0}}));
  EXPECT_TRUE(defect_of(kRuler, {{1, 1, 0}, {1, 1, 0}}));
  EXPECT_TRUE(defect_of(kRuler, {{0, 0, NAN}, {1, 0, 0}}));
  EXPECT_TRUE(defect_of(kRuler, {{0, 0, 2e9}, {1, 0, 0}}));
  EXPECT_FALSE(defect_of(kAngle, {{1, 0, 0}, {0, 0, 0}, {1, 0, 0}})) << "an angle of 0";
  EXPECT_TRUE(defect_of(kAngle, {{1, 0, 0}, {1, 0, 0}, {2, 0, 0}}));
  EXPECT_FALSE(defect_of(kEllipse, {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}}));
  EXPECT_TRUE(defect_of(kEllipse, {{0, 0, 0}, {2, 0, 0}, {1, 1, 0}}));
  EXPECT_TRUE(defect_of(kEllipse, {{0, 0, 0}, {2, 0, 0}, {0, 0, 0}}));
}

TEST(EllipseIntensities, OfADiscInASliceAreThoseOfItsVoxelsAlone) {
  VolumeGeometry geometry;
  geometry.size = {40, 30, 9};
  geometry.spacing_mm = {0.5, 1, 3};
  geometry.origin_mm = {-10, -15, 7};
  Volume volume(geometry, VoxelType::Float32);
  for (int k = 0; k < 9; ++k)
    for (int j = 0; j < 30; ++j)
      for (int i = 0; i < 40; ++i) volume.voxels<float>()[volume.offset(i, j, k)] = static_cast<float>(100 * k + i);
  const Eigen::Vector3d centre = geometry.world_from_index() * Eigen::Vector3d(20, 15, 4);
  const Measurement disc{
      0, kEllipse, {centre, centre + Eigen::Vector3d(5, 0, 0), centre + Eigen::Vector3d(0, 5, 0)}, ""};
  const auto found = ellipse_intensities(disc, volume);
  ASSERT_TRUE(found);
  EXPECT_DOUBLE_EQ(found->mean, 420) << "symmetrical about column 20 of slice 4";
  EXPECT_EQ(found->minimum, 410) << "the border belongs to the ellipse";
  EXPECT_EQ(found->maximum, 430);
  EXPECT_NEAR(static_cast<double>(found->voxels) * 0.5, ellipse_area_mm2(disc), 4);
  volume.voxels<float>()[volume.offset(20, 15, 4)] = NAN;
  EXPECT_EQ(ellipse_intensities(disc, volume)->voxels, found->voxels - 1) << "not finite";
}

TEST(EllipseIntensities, OfAPlaneBetweenSlicesAreThoseOfOneSlice) {
  VolumeGeometry geometry;
  geometry.size = {20, 20, 6};
  Volume volume(geometry, VoxelType::UInt8);
  for (std::size_t v = 0; v < volume.voxels<std::uint8_t>().size(); ++v)
    volume.voxels<std::uint8_t>()[v] = static_cast<std::uint8_t>(v / 400);
  const Eigen::Vector3d c(10, 10, 2.5);
  const Measurement up{0, kEllipse, {c, c + Eigen::Vector3d(4, 0, 0), c + Eigen::Vector3d(0, 4, 0)}, ""},
      down{0, kEllipse, {c, c + Eigen::Vector3d(0, 4, 0), c + Eigen::Vector3d(4, 0, 0)}, ""};
  EXPECT_EQ(ellipse_intensities(up, volume)->minimum, 3);
  EXPECT_EQ(ellipse_intensities(up, volume)->maximum, 3);
  EXPECT_EQ(ellipse_intensities(down, volume)->minimum, 2);
  EXPECT_EQ(ellipse_intensities(down, volume)->maximum, 2);
}

TEST(EllipseIntensities, AgreeWithTheDefinitionForAnyPlaneAndGrid) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> length(0.3, 12);
  int filled = 0;
  for (int trial = 0; trial < 80; ++trial) {
    VolumeGeometry geometry;
    geometry.size = {24, 18, 20};
    geometry.spacing_mm = {0.8, 1.1, 1.7};
    const Eigen::Matrix3d turn = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
                                     .normalized()
                                     .toRotationMatrix();
    if (trial % 2) geometry.direction = turn;
    if (trial % 4 == 1) geometry.direction.col(1) += 0.3 * geometry.direction.col(0);  // sheared
    const Volume volume = random_volume(random, geometry);
    const Eigen::Vector3d centre =
        geometry.centre_mm() + 5 * Eigen::Vector3d(normal(random), normal(random), normal(random));
    const Eigen::Matrix3d plane = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
                                      .normalized()
                                      .toRotationMatrix();
    const Measurement ellipse{
        0, kEllipse, {centre, centre + length(random) * plane.col(0), centre + length(random) * plane.col(1)}, ""};
    const auto found = ellipse_intensities(ellipse, volume), expected = reference_intensities(ellipse, volume);
    ASSERT_EQ(found.has_value(), expected.has_value()) << trial;
    if (!found) continue;
    ++filled;
    EXPECT_EQ(found->voxels, expected->voxels) << trial;
    EXPECT_NEAR(found->mean, expected->mean, 1e-9) << trial;
    EXPECT_NEAR(found->deviation, expected->deviation, 1e-9) << trial;
    EXPECT_EQ(found->minimum, expected->minimum) << trial;
    EXPECT_EQ(found->maximum, expected->maximum) << trial;
  }
  EXPECT_GT(filled, 60);
}

TEST(EllipseIntensities, NeedAVoxel) {
  std::mt19937 random(3);
  VolumeGeometry geometry;
  geometry.size = {4, 4, 4};
  const Volume volume = random_volume(random, geometry);
  const Measurement outside{0, kEllipse, {{50, 50, 50}, {51, 50, 50}, {50, 51, 50}}, ""};
  EXPECT_FALSE(ellipse_intensities(outside, volume));
  const Measurement small{0, kEllipse, {{1.5, 1.5, 1}, {1.6, 1.5, 1}, {1.5, 1.6, 1}}, ""};
  EXPECT_FALSE(ellipse_intensities(small, volume)) << "between the centres of voxels";
  EXPECT_FALSE(ellipse_intensities(small, Volume()));
}

}  // namespace
}  // namespace simplexseg
