// SPDX-License-Identifier: Apache-2.0
// Slices drawn by the engine, slice geometry and automatic contrast.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gpu/backend.h"
#include "gui/look/contrast.h"
#include "gui/look/slice_geometry.h"
#include "image/volume.h"
#include "step/engine.h"

namespace simplexseg {
namespace {

// Volume whose neighbouring voxels all differ.
template <class T>
Volume make_volume(const Eigen::Matrix3d& direction) {
  VolumeGeometry geometry;
  geometry.size = {7, 6, 5};
  geometry.spacing_mm = {1.5, 2.0, 3.0};
  geometry.origin_mm = {-4, 11, 30};
  geometry.direction = direction;
  Volume volume(geometry, voxel_type_of<T>());
  auto voxels = volume.voxels<T>();
  for (std::size_t n = 0; n < voxels.size(); ++n) voxels[n] = static_cast<T>((n * 37) % 101);
  return volume;
}

Eigen::Matrix3d permuted(int i, int j, int k, double si, double sj, double sk) {
  Eigen::Matrix3d direction = Eigen::Matrix3d::Zero();
  direction(i, 0) = si;
  direction(j, 1) = sj;
  direction(k, 2) = sk;
  return direction;
}

constexpr double kLow = 10, kHigh = 90;  // window of intensities; some voxels lie beyond it

// Largest difference between the texels of an engine's slices and the volume, and the number of texels inside.
double largest_error(const Volume& volume, const Eigen::Vector3d& through_mm, int* inside_count = nullptr,
                     int texels_per_voxel = 1) {
  const auto engine = make_cpu_engine(1);
  engine->set_volume(volume);
  double worst = 0;
  int inside = 0;
  for (const Orientation orientation : kOrientations) {
    const SliceGrid grid = slice_grid(volume.geometry(), orientation, through_mm, texels_per_voxel);
    std::vector<DisplayTexel> texels(static_cast<std::size_t>(grid.width) * grid.height);
    engine->draw_slice(slice_plane(volume.geometry(), grid, kHigh - kLow, (kLow + kHigh) / 2), {nullptr, texels});
    for (int v = 0; v < grid.height; ++v) {
      for (int u = 0; u < grid.width; ++u) {
        const Eigen::Vector3d world = grid.origin_mm + u * grid.step_u_mm + v * grid.step_v_mm;
        const DisplayTexel shown = texels[static_cast<std::size_t>(v) * grid.width + u];
        const Eigen::Vector3d index = volume.geometry().index_from_world() * world;
        double margin = 1e9;  // voxels to the nearest outer face, < 0 outside
        for (int axis = 0; axis < 3; ++axis) {
          margin = std::min({margin, index[axis] + 0.5, volume.geometry().size[axis] - 0.5 - index[axis]});
        }
        if (std::abs(margin) < 0.01) continue;
        EXPECT_EQ(shown.inside, margin < 0 ? 0 : 255) << world.transpose();
        if (margin < 0) {
          EXPECT_EQ(shown.grey, 0);
          continue;
        }
        ++inside;
        const double grey = std::clamp((volume.sample(world) - kLow) / (kHigh - kLow), 0.0, 1.0) * 255;
        worst = std::max(worst, std::abs(shown.grey - grey));
      }
    }
  }
  if (inside_count) *inside_count = inside;
  return worst;
}

TEST(SliceGeometry, APositionHasDecimalsForTheFinestSpacing) {
  VolumeGeometry geometry;
  for (const auto& [spacing_mm, decimals] :
       {std::pair{100.0, 1}, {1.0, 1}, {0.1, 1}, {0.05, 3}, {0.008, 4}, {1e-9, 6}}) {
    geometry.spacing_mm = {1, spacing_mm, 1};
    EXPECT_EQ(position_decimals(geometry), decimals) << spacing_mm;
  }
}

constexpr double kRounding = 0.5001;  // largest error of rounding to an integer grey value

TEST(DrawnSlice, ShowsTheVoxelsUnderEveryAxisAssignment) {
  const Eigen::Matrix3d directions[] = {permuted(0, 1, 2, 1, 1, 1), permuted(0, 1, 2, -1, -1, 1),
                                        permuted(1, 2, 0, 1, -1, 1), permuted(2, 0, 1, -1, 1, 1),
                                        permuted(0, 2, 1, 1, 1, -1)};
  for (const Eigen::Matrix3d& direction : directions) {
    const Volume volume = make_volume<std::int16_t>(direction);
    ASSERT_TRUE(is_axis_aligned(volume.geometry()));
    const Eigen::Vector3d centre = snap_to_voxel(volume.geometry(), volume.geometry().centre_mm());
    int inside = 0;
    EXPECT_LT(largest_error(volume, centre, &inside), kRounding);
    EXPECT_EQ(inside, 7 * 6 + 6 * 5 + 7 * 5);  // each voxel of the three slices once, nothing outside
    EXPECT_LT(largest_error(volume, centre, &inside, 3), kRounding + 0.01);
    EXPECT_EQ(inside, 9 * (7 * 6 + 6 * 5 + 7 * 5));
  }
}

TEST(DrawnSlice, TheOutermostSlicesAreInside) {
  const Volume volume = make_volume<std::uint8_t>(permuted(1, 2, 0, 1, -1, 1));
  for (const double far : {-900.0, 900.0}) {
    const Eigen::Vector3d corner = snap_to_voxel(volume.geometry(), Eigen::Vector3d::Constant(far));
    int inside = 0;
    EXPECT_LT(largest_error(volume, corner, &inside), kRounding);
    EXPECT_EQ(inside, 7 * 6 + 6 * 5 + 7 * 5);
  }
}

TEST(DrawnSlice, LiesExactlyOnTheVoxels) {
  const Volume volume = make_volume<std::int16_t>(permuted(2, 0, 1, -1, 1, 1));
  const Eigen::Vector3d centre = snap_to_voxel(volume.geometry(), volume.geometry().centre_mm());
  for (const Orientation orientation : kOrientations) {
    const SlicePlane plane = slice_plane(volume.geometry(), slice_grid(volume.geometry(), orientation, centre), 80, 50);
    for (const Vec3& v : {plane.origin, plane.step_u, plane.step_v}) {
      for (const float component : {v.x, v.y, v.z}) EXPECT_EQ(component, std::round(component));
    }
    EXPECT_EQ(plane.low, 10);
    EXPECT_EQ(plane.high, 90);
  }
}

TEST(DrawnSlice, InterpolatesUnderObliqueAndShearedDirections) {
  const Eigen::Matrix3d tilted = (Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized())).toRotationMatrix();
  Eigen::Matrix3d sheared = tilted;
  sheared.col(2) = (sheared.col(2) + 0.3 * sheared.col(0)).normalized();
  for (const Eigen::Matrix3d& direction : {tilted, sheared}) {
    const Volume volume = make_volume<float>(direction);
    EXPECT_FALSE(is_axis_aligned(volume.geometry()));
    int inside = 0;
    EXPECT_LT(largest_error(volume, volume.geometry().centre_mm() + Eigen::Vector3d(0.3, -0.2, 0.4), &inside),
              kRounding + 0.01);
    EXPECT_GT(inside, 50);
  }
}

template <class T>
class DrawnSliceTypes : public ::testing::Test {};
using VoxelTypes = ::testing::Types<std::int8_t, std::uint8_t, std::int16_t, std::uint16_t, std::int32_t, std::uint32_t,
                                    float, double>;
TYPED_TEST_SUITE(DrawnSliceTypes, VoxelTypes);
TYPED_TEST(DrawnSliceTypes, EveryVoxelTypeIsRead) {
  const Volume volume = make_volume<TypeParam>(Eigen::Matrix3d::Identity());
  EXPECT_LT(largest_error(volume, volume.geometry().centre_mm()), kRounding + 0.01);
}

TEST(SliceGeometry, LettersNameThePatientsSides) {
  // LPS: +x left, +y posterior, +z superior.
  EXPECT_EQ(letter_of({1, 0, 0}), 'L');
  EXPECT_EQ(letter_of({-1, 0, 0}), 'R');
  EXPECT_EQ(letter_of({0, 1, 0}), 'P');
  EXPECT_EQ(letter_of({0, -1, 0}), 'A');
  EXPECT_EQ(letter_of({0, 0, 1}), 'S');
  EXPECT_EQ(letter_of({0, 0, -1}), 'I');
}

TEST(SliceGeometry, RadiologicalShowsThePatientsRightOnTheLeft) {
  for (const Orientation orientation : {Orientation::Axial, Orientation::Coronal}) {
    EXPECT_EQ(letter_of(-slice_axes(orientation, Convention::Radiological).right), 'R');
    EXPECT_EQ(letter_of(-slice_axes(orientation, Convention::Neurological).right), 'L');
  }
  EXPECT_EQ(letter_of(slice_axes(Orientation::Axial, Convention::Radiological).up), 'A');
  EXPECT_EQ(letter_of(slice_axes(Orientation::Sagittal, Convention::Radiological).up), 'S');
  EXPECT_EQ(letter_of(-slice_axes(Orientation::Sagittal, Convention::Radiological).right), 'A');
}

TEST(SliceGeometry, SnapsToVoxelCentresAndIntoTheVolume) {
  const Volume volume = make_volume<std::uint8_t>(permuted(1, 2, 0, 1, -1, 1));
  const Eigen::Vector3d snapped =
      snap_to_voxel(volume.geometry(), volume.geometry().centre_mm() + Eigen::Vector3d(900, 0.4, 0));
  const Eigen::Vector3d index = volume.geometry().index_from_world() * snapped;
  EXPECT_LT((index - index.array().round().matrix()).norm(), 1e-9);
  EXPECT_TRUE(volume.geometry().contains(snapped));
}

TEST(Contrast, CoversTheObjectAndNotTheOutlier) {
  VolumeGeometry geometry;
  geometry.size = {40, 40, 40};
  Volume volume(geometry, VoxelType::Int16);
  auto voxels = volume.voxels<std::int16_t>();
  for (std::size_t n = 0; n < voxels.size(); ++n) voxels[n] = n % 3 == 0 ? static_cast<std::int16_t>(n % 200) : 0;
  voxels[5] = 30000;
  const Volume::Range range = contrast_range(volume);
  EXPECT_EQ(range.min, 0);
  EXPECT_GT(range.max, 150);
  EXPECT_LT(range.max, 250);
}

TEST(Contrast, HounsfieldUnitsShowSoftTissue) {
  VolumeGeometry geometry;
  geometry.size = {20, 20, 20};
  Volume volume(geometry, VoxelType::Int16);
  auto voxels = volume.voxels<std::int16_t>();
  for (std::size_t n = 0; n < voxels.size(); ++n)
    voxels[n] = static_cast<std::int16_t>(n % 4 == 0 ? -1000 : n % 1500 - 100);
  const Volume::Range range = contrast_range(volume);
  EXPECT_EQ(range.min, -160);
  EXPECT_EQ(range.max, 240);
}

TEST(Contrast, AConstantVolumeHasAUsableWindow) {
  VolumeGeometry geometry;
  geometry.size = {4, 4, 4};
  const Volume::Range range = contrast_range(Volume(geometry, VoxelType::Float32));
  EXPECT_LT(range.min, range.max);
}

}  // namespace
}  // namespace simplexseg
