// SPDX-License-Identifier: Apache-2.0
// Sections of an image through a transform, against the image's own interpolation.
#include "image/plane_samples.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "core/thread_pool.h"

namespace simplexseg {
namespace {

template <class T>
Volume textured(int depth = 7) {
  VolumeGeometry geometry;
  geometry.size = {9, 8, depth};
  geometry.spacing_mm = {1.5, 2, 3};
  geometry.origin_mm = {-4, 11, 30};
  geometry.direction = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  Volume volume(geometry, voxel_type_of<T>());
  auto voxels = volume.voxels<T>();
  for (std::size_t n = 0; n < voxels.size(); ++n) voxels[n] = static_cast<T>((n * 37) % 101);
  return volume;
}

PlaneGrid oblique_grid(const Volume& volume) {
  PlaneGrid grid;
  grid.step_u_mm = {0.7, 0.1, 0.2}, grid.step_v_mm = {-0.1, 0.6, 0.3};
  grid.width = 60, grid.height = 50;
  grid.origin_mm = volume.geometry().centre_mm() - 30 * grid.step_u_mm - 25 * grid.step_v_mm;
  return grid;
}

std::vector<PlaneSample> samples_of(const Volume& volume, const Transform& transform, const PlaneGrid& grid,
                                    int threads = 1) {
  std::vector<PlaneSample> samples(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height));
  ThreadPool pool(threads);
  sample_plane(volume, transform, grid, samples, pool);
  return samples;
}

/// Compares all samples with Volume::sample() at the transformed points, and returns the number within the image.
int expect_interpolated(const Volume& volume, const Transform& transform) {
  const PlaneGrid grid = oblique_grid(volume);
  const std::vector<PlaneSample> samples = samples_of(volume, transform, grid);
  int inside = 0;
  for (int v = 0; v < grid.height; ++v)
    for (int u = 0; u < grid.width; ++u) {
      const PlaneSample& sample = samples[static_cast<std::size_t>(v * grid.width + u)];
      const Eigen::Vector3d at = transform(grid.origin_mm + u * grid.step_u_mm + v * grid.step_v_mm);
      EXPECT_EQ(sample.inside, volume.geometry().contains(at) ? 1.0f : 0.0f);
      if (sample.inside == 0) {
        EXPECT_EQ(sample.value, 0.0f);
        continue;
      }
      EXPECT_NEAR(sample.value, volume.sample(at), 1e-3);
      ++inside;
    }
  return inside;
}

Eigen::Affine3d moved() {
  Eigen::Affine3d affine = Eigen::Affine3d::Identity();
  affine.linear() = Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX()).toRotationMatrix() * 1.1;
  affine.translation() = Eigen::Vector3d(1, -2, -3.5);
  return affine;
}

TEST(PlaneSamples, AreInterpolatedThroughAffineMapsForEveryType) {
  EXPECT_GT(expect_interpolated(textured<std::uint8_t>(), Transform()), 100);
  EXPECT_GT(expect_interpolated(textured<std::int16_t>(), Transform(moved())), 100);
  EXPECT_GT(expect_interpolated(textured<float>(), Transform(moved())), 100);
  EXPECT_GT(expect_interpolated(textured<double>(), Transform()), 100);
}

TEST(PlaneSamples, AreInterpolatedThroughDisplacementFields) {
  VolumeGeometry grid;
  grid.size = {5, 5, 5}, grid.spacing_mm = {8, 8, 8}, grid.origin_mm = {-15, 0, 20};
  std::vector<Eigen::Vector3f> vectors(125);
  for (std::size_t n = 0; n < vectors.size(); ++n)
    vectors[n] = Eigen::Vector3f(std::sin(static_cast<float>(n)), std::cos(static_cast<float>(n)), 1);
  Transform transform;
  transform.append(DisplacementField(grid, vectors));
  transform.append(moved());
  EXPECT_GT(expect_interpolated(textured<float>(), transform), 100);
}

TEST(PlaneSamples, OfASingleSliceAreThoseOfTheSlice) {
  EXPECT_GT(expect_interpolated(textured<std::int16_t>(1), Transform()), 50);
}

TEST(PlaneSamples, HaveTheSameBitsForAnyNumberOfThreads) {
  const Volume volume = textured<float>();
  const std::vector<PlaneSample> one = samples_of(volume, Transform(moved()), oblique_grid(volume)),
                                 four = samples_of(volume, Transform(moved()), oblique_grid(volume), 4);
  EXPECT_EQ(std::memcmp(one.data(), four.data(), one.size() * sizeof one[0]), 0);
}

TEST(PlaneSamples, ValuesThatAreNotFiniteAreOutside) {
  Volume volume = textured<float>();
  volume.voxels<float>()[volume.offset(4, 4, 3)] = std::numeric_limits<float>::quiet_NaN();
  PlaneGrid point;
  point.width = point.height = 1;
  point.origin_mm = volume.geometry().world_from_index() * Eigen::Vector3d(4, 4, 3);
  EXPECT_EQ(samples_of(volume, Transform(), point)[0].inside, 0.0f);
  point.origin_mm = volume.geometry().world_from_index() * Eigen::Vector3d(6, 4, 3);
  EXPECT_EQ(samples_of(volume, Transform(), point)[0].inside, 1.0f);
}

}  // namespace
}  // namespace simplexseg
