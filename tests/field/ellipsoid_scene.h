// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "field/marks.h"
#include "image/mask.h"
#include "image/volume.h"

namespace simplexseg {

inline Mark inside(const Eigen::Vector3d& at, double radius) { return {MarkKind::Inside, at, radius, {0, 0, 0}}; }
inline Mark outside(const Eigen::Vector3d& at, double radius) { return {MarkKind::Outside, at, radius, {0, 0, 0}}; }

/// Image with noise of this standard deviation, and the mask of the object.
struct Scene {
  Volume image;
  Mask truth;
};
/// `value`: intensity at a place (mm) without noise; the object has at least 100.
template <class Value>
Scene scene_of(const VolumeGeometry& geometry, const Value& value, double noise) {
  Scene scene{Volume(geometry, VoxelType::Float32), {geometry, std::vector<std::uint8_t>(geometry.voxel_count())}};
  std::uint64_t state = 1;
  const auto uniform = [&] {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state >> 33) / 2147483648.0;
  };
  const Eigen::Affine3d world = geometry.world_from_index();
  for (int k = 0; k < geometry.size[2]; ++k) {
    for (int j = 0; j < geometry.size[1]; ++j) {
      for (int i = 0; i < geometry.size[0]; ++i) {
        const double at = value(world * Eigen::Vector3d(i, j, k));
        const std::size_t v = scene.image.offset(i, j, k);
        scene.truth.voxels[v] = at >= 100;
        const double scatter = uniform() + uniform() + uniform() + uniform() - 2;  // deviation 0.577
        scene.image.voxels<float>()[v] = static_cast<float>(at) + static_cast<float>(noise / 0.577 * scatter);
      }
    }
  }
  return scene;
}
/// Bright ellipsoid in the middle of a volume whose slices are `thick` times as thick as its voxels are wide.
inline Scene ellipsoid(int width, double thick, const Eigen::Vector3d& radii_mm, double noise = 0) {
  VolumeGeometry geometry;
  geometry.size = {width, width, static_cast<int>(width / thick)};
  geometry.spacing_mm = {1, 1, thick};
  for (int a = 0; a < 3; ++a) geometry.origin_mm[a] = -0.5 * geometry.spacing_mm[a] * (geometry.size[a] - 1);
  return scene_of(
      geometry, [&](const Eigen::Vector3d& p) { return p.cwiseQuotient(radii_mm).norm() <= 1 ? 150.0 : 50.0; }, noise);
}

}  // namespace simplexseg
