// SPDX-License-Identifier: Apache-2.0
#include "study/field_trials.h"

#include <numbers>
#include <utility>

namespace simplexseg {

VolumeGeometry grid_of(std::array<int, 3> size, const Eigen::Vector3d& spacing_mm, const Eigen::Matrix3d& direction) {
  VolumeGeometry grid;
  grid.size = size, grid.spacing_mm = spacing_mm, grid.direction = direction;
  grid.origin_mm = -grid.centre_mm();
  return grid;
}

double usual_value(const Eigen::Vector3d&, bool inside) { return inside ? 150 : 50; }

FieldTrial trial_with(const VolumeGeometry& grid, const Shape& shape, const Appearance& value, VoxelType type) {
  FieldTrial trial = trial_without_object(
      grid, [&](const Eigen::Vector3d& mm, bool) { return value(mm, shape(mm)); }, type);
  Mask truth{grid, std::vector<std::uint8_t>(grid.voxel_count())};
  const Eigen::Affine3d world = grid.world_from_index();
  std::size_t v = 0;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i, ++v) truth.voxels[v] = shape(world * Eigen::Vector3d(i, j, k));
  trial.truth = std::move(truth);
  return trial;
}

FieldTrial trial_without_object(const VolumeGeometry& grid, const Appearance& value, VoxelType type) {
  FieldTrial trial;
  Volume volume(grid, type);
  const Eigen::Affine3d world = grid.world_from_index();
  visit_voxel_type(type, [&]<class T>(std::type_identity<T>) {
    const std::span<T> voxels = volume.voxels<T>();
    std::size_t v = 0;
    for (int k = 0; k < grid.size[2]; ++k)
      for (int j = 0; j < grid.size[1]; ++j)
        for (int i = 0; i < grid.size[0]; ++i, ++v)
          voxels[v] = static_cast<T>(value(world * Eigen::Vector3d(i, j, k), false));
  });
  trial.volume = std::move(volume);
  return trial;
}

bool ball(const Eigen::Vector3d& mm) { return mm.norm() < kFieldBallMm; }
VolumeGeometry usual_grid() { return grid_of({48, 48, 48}); }
Mark usual_seed() { return inside_mark({1, -0.5, 0.5}, 6); }

Mark inside_mark(const Eigen::Vector3d& mm, double radius_mm) { return {MarkKind::Inside, mm, radius_mm, {0, 0, 0}}; }
Mark outside_mark(const Eigen::Vector3d& mm, double radius_mm) { return {MarkKind::Outside, mm, radius_mm, {0, 0, 0}}; }
Mark boundary_mark(const Eigen::Vector3d& mm, double radius_mm, const Eigen::Vector3d& outward) {
  return {MarkKind::Boundary, mm, radius_mm, outward};
}
double ball_mm3(double radius_mm) { return 4 * std::numbers::pi / 3 * radius_mm * radius_mm * radius_mm; }

double FieldNoise::uniform() {
  state_ += 0x9e3779b97f4a7c15u;
  std::uint64_t z = state_;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}
double FieldNoise::normal() {
  double sum = -6;
  for (int n = 0; n < 12; ++n) sum += uniform();
  return sum;
}

FieldCase trial_case(std::string name, std::string what, FieldOutcome stated, std::string reason,
                     std::function<FieldTrial()> make) {
  return {std::move(name), std::move(what), stated, std::move(reason),
          [make = std::move(make)](const FieldBackend& backend) { return run_trial(make(), backend); }};
}

}  // namespace simplexseg
