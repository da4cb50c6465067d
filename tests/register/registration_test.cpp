// SPDX-License-Identifier: Apache-2.0
#include "io/registration/registration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <thread>

#include "../io/test_files.h"
#include "core/error.h"
#include "io/platform/load_progress.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

using test::error_of;

Eigen::Affine3d known_map(const Eigen::Vector3d& centre, const Eigen::Vector3d& degrees, const Eigen::Vector3d& shift,
                          double scale = 1) {
  const Eigen::Vector3d radians = degrees * std::numbers::pi / 180;
  const Eigen::Quaterniond rotation = Eigen::AngleAxisd(radians[0], Eigen::Vector3d::UnitX()) *
                                      Eigen::AngleAxisd(radians[1], Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(radians[2], Eigen::Vector3d::UnitZ());
  return Eigen::Translation3d(centre + shift) * rotation * Eigen::Scaling(scale) * Eigen::Translation3d(-centre);
}

/// Contrast like that of a T2 weighted image: it is not monotonic.
double other_contrast(double value) {
  return value < 55 ? 4.5 * value : value < 200 ? 250 - 1.2 * (value - 55) : 76 + value - 200;
}

/// Every second voxel of ch2 along each axis, and a copy of it that is moved, with another contrast and noise.
class RegistrationTest : public ::testing::Test {
 protected:
  void SetUp() override {
    REQUIRE_DATA(test::templates_folder / "ch2.nii.gz");
    const Volume full = read_volume(test::templates_folder / "ch2.nii.gz");
    VolumeGeometry grid = full.geometry();
    for (std::size_t a = 0; a < 3; ++a) grid.size[a] = (grid.size[a] - 1) / 2;
    grid.origin_mm = full.geometry().world_from_index() * Eigen::Vector3d(0.5, 0.5, 0.5);
    grid.spacing_mm *= 2;
    fixed = resample_through(full, grid, Transform());
    centre = grid.centre_mm();
  }

  Volume moved(const Eigen::Affine3d& map) const {
    Volume source(fixed.geometry(), VoxelType::Float32);
    for (std::size_t n = 0; n < source.geometry().voxel_count(); ++n)
      source.voxels<float>()[n] = fixed.voxels<std::uint8_t>()[n];
    Volume result = resample_through(source, fixed.geometry(), Transform(map.inverse()));
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, 6);
    Volume last(fixed.geometry(), VoxelType::Float32);
    for (std::size_t n = 0; n < last.geometry().voxel_count(); ++n)
      last.voxels<float>()[n] = static_cast<float>(other_contrast(result.voxels<float>()[n]) + noise(random));
    return last;
  }

  /// Largest distance of both maps at points of the brain, mm.
  double error_mm(const Transform& found, const Eigen::Affine3d& map) const {
    double largest = 0;
    for (double x : {-50, 0, 50})
      for (double y : {-60, 0, 60})
        for (double z : {-40, 0, 40}) {
          const Eigen::Vector3d point = centre + Eigen::Vector3d(x, y, z);
          largest = std::max(largest, (found(point) - map * point).norm());
        }
    return largest;
  }

  Volume fixed;
  Eigen::Vector3d centre;
};

TEST_F(RegistrationTest, RigidMapsAreFoundFromFarAwayWithOtherContrast) {
  for (const auto& [degrees, shift] : {std::pair<Eigen::Vector3d, Eigen::Vector3d>{{20, -20, 20}, {30, -20, 10}},
                                       {{-20, 15, -20}, {-15, 30, -25}},
                                       {{0, 0, 0}, {0, 0, 0}}}) {
    const Eigen::Affine3d map = known_map(centre, degrees, shift);
    const RegistrationResult result = register_images(fixed, moved(map), {});
    EXPECT_LT(error_mm(result.transform, map), 0.3) << degrees.transpose();
    EXPECT_LE(result.metric_after, result.metric_before);
  }
}

TEST_F(RegistrationTest, AnAffineMapIsFoundWithEqualBitsForAnyNumberOfThreads) {
  const Eigen::Affine3d map = known_map(centre, {10, 5, -12}, {10, -8, 6}, 1.08);
  const Volume moving = moved(map);
  std::optional<Eigen::Matrix4d> first;
  for (const int threads : {1, 2, 4}) {
    const RegistrationResult result =
        register_images(fixed, moving, {.kind = RegistrationKind::Affine, .threads = threads});
    EXPECT_LT(error_mm(result.transform, map), 0.3);
    const Eigen::Matrix4d matrix = result.transform.affine()->matrix();
    if (!first) first = matrix;
    EXPECT_EQ(matrix, *first) << threads;
  }
}

TEST_F(RegistrationTest, AFieldHasEqualBitsForAnyNumberOfThreadsAndDoesNotFold) {
  VolumeGeometry grid = fixed.geometry();
  for (std::size_t a = 0; a < 3; ++a) grid.size[a] /= 3;
  grid.spacing_mm *= 3;
  const Volume coarse = resample_through(fixed, grid, Transform());
  const Volume moving = resample_through(fixed, grid, Transform(known_map(centre, {3, 0, 4}, {4, -3, 2}, 1.05)));
  std::vector<Eigen::Vector3f> first;
  for (const int threads : {1, 3}) {
    const RegistrationResult result =
        register_images(coarse, moving, {.kind = RegistrationKind::Displacement, .threads = threads});
    ASSERT_EQ(result.transform.steps().size(), 2u);
    const auto& vectors = std::get<DisplacementField>(result.transform.steps()[0]).vectors();
    if (first.empty()) first = vectors;
    EXPECT_EQ(vectors, first) << threads;
    EXPECT_EQ(jacobian_range(result.transform, grid).folded_share, 0);
  }
}

TEST_F(RegistrationTest, AGivenStartReachesWhatTheSearchDoesNot) {
  const Eigen::Affine3d map = known_map(centre, {0, 0, 120}, {5, 0, 0});
  const Volume moving = moved(map);
  RegistrationSettings settings;
  settings.initial = known_map(centre, {0, 0, 112}, {0, 4, 0});
  EXPECT_LT(error_mm(register_images(fixed, moving, settings).transform, map), 0.3);
}

TEST_F(RegistrationTest, ImagesThatDoNotOverlapOrAreConstantAreRefused) {
  VolumeGeometry far = fixed.geometry();
  far.origin_mm += Eigen::Vector3d(10000, 0, 0);
  Volume moving = resample_through(fixed, fixed.geometry(), Transform());
  Volume away(far, VoxelType::UInt8);
  std::copy_n(moving.voxels<std::uint8_t>().begin(), away.voxels<std::uint8_t>().size(),
              away.voxels<std::uint8_t>().begin());
  const std::string refused = error_of([&] { register_images(fixed, away, {.start = RegistrationStart::None}); });
  EXPECT_NE(refused.find("do not overlap"), std::string::npos) << refused;
  const Volume constant(fixed.geometry(), VoxelType::Int16);
  EXPECT_NE(error_of([&] { register_images(fixed, constant, {}); }).find("equal"), std::string::npos);
}

TEST_F(RegistrationTest, ProgressIsReportedAndACancellationEndsTheWork) {
  const Volume moving = moved(known_map(centre, {5, 5, 5}, {3, 3, 3}));
  int reports = 0;
  double done = 0;
  register_images(fixed, moving, {.kind = RegistrationKind::Affine}, [&](const RegistrationProgress& progress) {
    ++reports;
    EXPECT_GE(progress.done, 0);
    EXPECT_LE(progress.done, 1);
    done = std::max(done, progress.done);
  });
  EXPECT_GT(reports, 3);
  EXPECT_GT(done, 0.4);
  LoadProgress progress;
  const LoadProgress::Scope scope(progress);
  bool cancelled = false;
  try {
    register_images(fixed, moving, {}, [&](const RegistrationProgress&) { progress.cancel(); });
  } catch (const Cancelled&) {
    cancelled = true;
  }
  EXPECT_TRUE(cancelled);
}

TEST(Registration, AMissingProgramIsNamedInOneLine) {
  ::setenv("SIMPLEXSEG_REGISTER", "/nonexistent/program", 1);
  const Volume volume(VolumeGeometry{.size = {8, 8, 8}}, VoxelType::Int16);
  const std::string message = error_of([&] { register_images(volume, volume, {}); });
  ::unsetenv("SIMPLEXSEG_REGISTER");
  EXPECT_NE(message.find("simplexseg-register"), std::string::npos) << message;
}

}  // namespace
}  // namespace simplexseg
