// SPDX-License-Identifier: Apache-2.0
#include "study/trials.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "core/error.h"
#include "image/metrics.h"
#include "image/rasterise.h"
#include "mesh/mesh_geometry.h"
#include "step/simulation_parameters.h"
#include "study/mesh_check.h"

namespace simplexseg {

void set_value(ForceParameters& forces, const Value& value) {
  const ForceInfo* force = find_force(value.force);
  const int index = force ? find_parameter(force->parameters, value.parameter) : -1;
  if (index < 0)
    throw Error(std::string(value.force) + "." + value.parameter, "there is no such parameter",
                "use a name from docs/parameters.md");
  forces.values[static_cast<int>(force->id)][index] = value.value;
}

ForceParameters forces_with(std::initializer_list<Value> values) {
  ForceParameters forces = default_force_parameters();
  for (const ForceInfo& force : force_list()) forces.values[static_cast<int>(force.id)][0] = 0;
  // Trials test the engine, so evidence comes from the region model and not from a field.
  set_value(forces, {"evidence", "source", 1});
  set_value(forces, {"smoothing", "curvature", 0.5f});
  for (const Value& value : values) set_value(forces, value);
  return forces;
}

ForceParameters usual_forces() {
  return forces_with({{"smoothing", "weight", 0.5f}, {"evidence", "weight", 0.5f}, {"attraction", "weight", 2}});
}

SimulationParameters usual_settings() {
  SimulationParameters s = default_simulation_parameters();
  s.timestep = 1, s.damping = 0.9f, s.limit_timestep = 1, s.refresh_interval = 3;
  s.start_vertices = 320, s.final_vertices = 20;
  return s;
}

const Phantom& phantom_of(const std::string& kind) {
  static std::map<std::string, Phantom> phantoms;
  if (const auto found = phantoms.find(kind); found != phantoms.end()) return found->second;
  PhantomSettings settings;
  settings.size = kind == "sphere" ? 32 : 64, settings.spacing_mm = kind == "sphere" ? 2 : 1;
  settings.type = VoxelType::Float32;
  return phantoms.emplace(kind, make_phantom(kind, settings)).first->second;
}
const Volume& ball_volume() { return phantom_of("sphere").image; }

Volume scaled_and_shifted(const Volume& volume, double scale, const Eigen::Vector3d& shift_mm) {
  VolumeGeometry g = volume.geometry();
  g.spacing_mm *= scale;
  g.origin_mm = scale * g.origin_mm + shift_mm;
  Volume result(g, volume.type());
  std::memcpy(result.data(), volume.data(), volume.bytes());
  return result;
}

Volume volume_of(VoxelType type, std::array<int, 3> size, const Eigen::Vector3d& spacing_mm,
                 const std::function<double(const Eigen::Vector3d&)>& value) {
  VolumeGeometry g;
  g.size = size, g.spacing_mm = spacing_mm;
  for (int a = 0; a < 3; ++a) g.origin_mm[a] = -0.5 * (size[a] - 1) * spacing_mm[a];
  Volume volume(g, type);
  const Eigen::Affine3d world_from_index = g.world_from_index();
  visit_voxel_type(type, [&]<class T>(std::type_identity<T>) {
    const std::span<T> voxels = volume.voxels<T>();
    for (int k = 0; k < size[2]; ++k)
      for (int j = 0; j < size[1]; ++j)
        for (int i = 0; i < size[0]; ++i)
          voxels[volume.offset(i, j, k)] = static_cast<T>(value(world_from_index * Eigen::Vector3d(i, j, k)));
  });
  return volume;
}

SimplexMesh transformed(SimplexMesh mesh, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& map) {
  for (Eigen::Vector3f& p : mesh.positions) p = map(p.cast<double>()).cast<float>();
  return mesh;
}

SimplexMesh add_noise(SimplexMesh mesh, double share) {
  const double size = share * measure(mesh).mean_edge_mm;
  std::uint64_t counter = 0;
  const auto uniform = [&] {  // random number in [-1, 1) by splitmix64
    std::uint64_t z = ++counter * 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1;
  };
  return transformed(std::move(mesh), [&](const Eigen::Vector3d& p) {
    const double x = uniform(), y = uniform(), z = uniform();
    return (p + size * Eigen::Vector3d(x, y, z)).eval();
  });
}

Trial trial_of(SimplexMesh mesh, const Volume& volume, const ForceParameters& forces) {
  Trial trial;
  MeshItem item;
  item.id = 1, item.name = "ball", item.parameters = forces;
  item.seed = {mean_position(mesh), 10};
  item.mesh = std::move(mesh);
  trial.scene.meshes.push_back(std::move(item));
  trial.scene.simulation = usual_settings();
  trial.volume = volume;
  return trial;
}

Trial ball_trial() {
  Trial trial = trial_of(make_sphere({1, -0.5, 0.5}, 15, 2), ball_volume(), usual_forces());
  trial.error = radial_error(kBallRadius);
  trial.tolerance = 1.5;
  return trial;
}

void add_point(Trial& trial, const Eigen::Vector3d& position_mm) {
  trial.scene.points.push_back({static_cast<ItemId>(100 + trial.scene.points.size()), 1, position_mm});
}

std::function<double(const Scene&)> radial_error(double radius_mm, const Eigen::Vector3d& centre_mm) {
  return [=](const Scene& end) {
    double largest = 0;
    for (const Eigen::Vector3f& p : end.meshes[0].mesh.positions)
      largest = std::max(largest, std::abs((p.cast<double>() - centre_mm).norm() - radius_mm));
    return largest;
  };
}

std::function<double(const Scene&)> distance_to(const Eigen::Vector3d& position_mm) {
  return [=](const Scene& end) {
    double nearest = INFINITY;
    for (const Eigen::Vector3f& p : end.meshes[0].mesh.positions)
      nearest = std::min(nearest, (p.cast<double>() - position_mm).norm());
    return nearest;
  };
}

std::function<double(const Scene&)> distance_from(const SimplexMesh& start) {
  return [positions = start.positions](const Scene& end) {
    double largest = 0;
    for (std::size_t i = 0; i < positions.size(); ++i)
      largest = std::max<double>(largest, (positions[i] - end.meshes[0].mesh.positions[i]).norm());
    return largest;
  };
}

std::function<double(const Scene&)> volume_error(const SimplexMesh& start) {
  return [volume = measure(start).volume_mm3](const Scene& end) {
    return std::abs(measure(end.meshes[0].mesh).volume_mm3 / volume - 1);
  };
}

std::function<double(const Scene&)> dice_error(const Volume& labels) {
  return [truth = mask_of(labels, std::nullopt)](const Scene& end) {
    return 1 - dice(truth, rasterise(end.meshes[0].mesh, truth.geometry));
  };
}

}  // namespace simplexseg
