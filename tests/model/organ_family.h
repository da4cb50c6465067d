// SPDX-License-Identifier: Apache-2.0
// Family of bent ellipsoids in noise, of different size, place, orientation and bend, beside a ball of the same
// intensity that touches them.
#pragma once
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "model/model_training.h"
#include "model/similarity.h"

namespace simplexseg {

struct OrganOptions {
  double inside = 130, outside = 100, deviation = 12;
  double shift_x_mm = 0;  ///< moves the grid, so that it cuts the organ
};

inline ModelCase make_organ(std::uint32_t number, const OrganOptions& options = {}) {
  std::mt19937 random(number + 1);
  const auto uniform = [&](double low, double high) {  // independent of the standard library
    return low + (high - low) * (random() / 4294967296.0);
  };
  const double scale = uniform(0.85, 1.15), bend = uniform(-0.02, 0.03);
  const Eigen::Vector3d radii = scale * Eigen::Vector3d(9, 16, 8);
  const Eigen::Matrix3d turn =
      rotation_of({uniform(-0.15, 0.15), uniform(-0.15, 0.15), uniform(-0.15, 0.15)}).transpose();
  const Eigen::Vector3d centre(uniform(-3, 3), uniform(-3, 3), uniform(-3, 3));
  VolumeGeometry grid;
  grid.size = {44, 56, 44};
  for (int a = 0; a < 3; ++a) grid.origin_mm[a] = -0.5 * (grid.size[a] - 1);
  grid.origin_mm[0] += options.shift_x_mm;
  ModelCase organ{"organ " + std::to_string(number),
                  Volume(grid, VoxelType::Float32),
                  {grid, std::vector<std::uint8_t>(grid.voxel_count())},
                  {}};
  const Eigen::Affine3d world = grid.world_from_index();
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        Eigen::Vector3d p = turn * (world * Eigen::Vector3d(i, j, k) - centre);
        p.x() -= bend * p.y() * p.y();
        const bool in = p.cwiseQuotient(radii).norm() <= 1;
        const bool beside = (p - Eigen::Vector3d(0, -radii.y() - 5, 0)).norm() <= 7;
        const std::size_t v = organ.image.offset(i, j, k);
        organ.object.voxels[v] = in;
        const double noise = uniform(-1, 1) + uniform(-1, 1) + uniform(-1, 1);  // deviation 1
        organ.image.voxels<float>()[v] =
            static_cast<float>((in || beside ? options.inside : options.outside) + options.deviation * noise);
      }
  return organ;
}

inline std::vector<ModelCase> make_organs(int first, int count) {
  std::vector<ModelCase> organs;
  for (int n = first; n < first + count; ++n) organs.push_back(make_organ(static_cast<std::uint32_t>(n)));
  return organs;
}

/// Model of the first organs, trained once.
inline const OrganModel& model_of_organs() {
  static const OrganModel model = [] {
    const std::vector<ModelCase> cases = make_organs(0, 12);
    const TrainingSettings settings{.vertices = 400, .modes = 40};
    return train_model(register_cases(cases, settings, run_serially()), settings, run_serially());
  }();
  return model;
}

}  // namespace simplexseg
