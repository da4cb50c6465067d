// SPDX-License-Identifier: Apache-2.0
#include "study/study_scene.h"

#include <algorithm>
#include <cmath>

#include "image/mask.h"
#include "mesh/simplex_mesh.h"
#include "step/simulation_parameters.h"
#include "study/trials.h"

namespace simplexseg {

StudyScene make_phantom_scene(bool half, int vertices) {
  constexpr double kRadiusMm = 24;
  constexpr int kSize = 64;
  const Eigen::Vector3d radii(26, 24, 22);
  // First-order distance near the surface: value of the level-set function divided by the norm of its gradient, mm.
  const auto distance = [&](const Eigen::Vector3d& p) {
    const double level = p.cwiseQuotient(radii).norm();
    const double slope = p.cwiseQuotient(radii.cwiseProduct(radii)).norm();
    return level > 0.1 ? (level - 1) * level / slope : -radii.minCoeff();
  };
  StudyScene study;
  study.volume = volume_of(VoxelType::Float32, {kSize, kSize, kSize}, {1, 1, 1}, [&](const Eigen::Vector3d& p) {
    return half && p.z() < 0 ? 50.0 : 100 / (1 + std::exp(std::clamp(distance(p) / 0.6, -40.0, 40.0)));
  });
  auto truth = std::make_shared<Mask>();
  truth->geometry = study.volume.geometry();
  const Eigen::Affine3d world = truth->geometry.world_from_index();
  for (int k = 0; k < kSize; ++k)
    for (int j = 0; j < kSize; ++j)
      for (int i = 0; i < kSize; ++i) truth->voxels.push_back(distance(world * Eigen::Vector3d(i, j, k)) < 0);
  study.frozen_from_start = true;
  const int count = 20 << (2 * sphere_level_for(vertices));
  study.name = std::string("phantom-") + (half ? "half-" : "full-") + std::to_string(count);
  Scene& scene = study.scene;
  scene.simulation = default_simulation_parameters();
  scene.simulation.start_vertices = scene.simulation.final_vertices = static_cast<float>(count);
  scene.simulation.finest_edge = 0;
  scene.steps = 600;
  MeshItem item;
  item.name = "ball";
  item.seed = {{0, 0, 0}, kRadiusMm};
  // Shape memory is unsuitable if half of the surface is free: sliding along the surface and motions of the free
  // hemisphere have hardly any stiffness, so the fixed point would not be unique.
  item.parameters =
      half ? forces_with({{"smoothing", "weight", 5}, {"smoothing", "evenness", 0}, {"smoothing", "curvature", 0}})
           : forces_with({{"shape_memory", "weight", 5}});
  for (const Value& value : {Value{"gradient", "weight", 0.5f}, {"gradient", "object", 1}, {"gradient", "pull", 0}})
    set_value(item.parameters, value);
  scene.meshes.push_back(item);
  study.truths.push_back(half ? nullptr : truth);
  return study;
}

}  // namespace simplexseg
