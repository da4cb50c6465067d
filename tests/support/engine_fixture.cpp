// SPDX-License-Identifier: Apache-2.0
#include "support/engine_fixture.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <tuple>

#include "forces/force_list.h"
#include "forces/region_model.h"
#include "mesh/mesh_geometry.h"
#include "mesh/shape_reference.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

constexpr Setting kBaseline[] = {
    {"smoothing", "evenness", 2},
    {"smoothing", "curvature", 1},
    {"smoothing", "elevation_limit", 0.4f},
    {"shape_memory", "scaling", 0.5f},
    {"gradient", "samples", 6},
    {"gradient", "spacing", 0.5f},
    {"gradient", "object", 0},
    {"gradient", "threshold", 0.01f},
    {"gradient", "pull", 1},
    {"intensity_profile", "half_length", 4},
    {"intensity_profile", "samples", 6},
    {"intensity_profile", "spacing", 0.5f},
    {"intensity_profile", "measure", 0},
    {"intensity_profile", "acceptance", 0.2f},
    {"intensity_profile", "pull", 1},
    {"evidence", "reach", 2},
    {"evidence", "samples", 8},
    {"evidence", "edge", 1},
    {"evidence", "nearness", 0.1f},
    {"evidence", "local", 0.5f},
    {"evidence", "averaging", 2},
    {"evidence", "pull", 2},
    {"evidence", "balloon", 0},
    {"evidence", "source", 1},
    {"attraction", "order", 5},
    {"attraction", "image_fade", 1},
};

/// Counter-based random number in [0, 1); the distributions of the standard library differ between machines.
double uniform(std::uint64_t counter) {
  std::uint64_t z = counter * 0x9E3779B97F4A7C15u + 0x632BE59BD9B4E019u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

}  // namespace

void set(ForceParameters& forces, const Setting& setting) {
  const ForceInfo* force = find_force(setting.force);
  ASSERT_NE(force, nullptr) << setting.force;
  const int index = find_parameter(force->parameters, setting.parameter);
  ASSERT_GE(index, 0) << setting.force << "." << setting.parameter;
  forces.values[static_cast<int>(force->id)][index] = setting.value;
}

ForceParameters weightless() {
  ForceParameters forces = default_force_parameters();
  for (const ForceInfo& force : force_list()) forces.values[static_cast<int>(force.id)][0] = 0;
  for (const Setting& setting : kBaseline) set(forces, setting);
  return forces;
}

ForceParameters with(std::initializer_list<Setting> settings) {
  ForceParameters forces = weightless();
  for (const Setting& setting : settings) set(forces, setting);
  return forces;
}

float& weight_of(ForceParameters& forces, ForceId force) { return forces.values[static_cast<int>(force)][0]; }

SimulationParameters simulation(float timestep, float damping, int refresh_interval) {
  SimulationParameters s = default_simulation_parameters();
  s.solver_choice = static_cast<float>(Solver::Verlet);
  s.timestep = timestep, s.damping = damping, s.limit_timestep = 0,
  s.refresh_interval = static_cast<float>(refresh_interval);
  return s;
}
SimulationParameters limited(float timestep, float damping, int refresh_interval) {
  SimulationParameters s = simulation(timestep, damping, refresh_interval);
  s.limit_timestep = 1;
  return s;
}

std::vector<EngineMesh> engine_meshes(const TestScene& scene) {
  std::vector<EngineMesh> meshes;
  for (const TestMesh& mesh : scene.meshes) {
    EngineMesh m;
    m.positions = mesh.mesh.positions;
    m.previous = mesh.previous.empty() ? mesh.mesh.positions : mesh.previous;
    m.neighbours = mesh.mesh.neighbours, m.shape = mesh.shape, m.profiles = mesh.profiles, m.region = &mesh.region;
    m.parameters = mesh.forces, m.finest = mesh.finest;
    meshes.push_back(m);
  }
  return meshes;
}

void load(Engine& engine, const TestScene& scene) {
  engine.set_volume(scene.volume);
  engine.load(engine_meshes(scene), scene.simulation);
  for (std::size_t k = 0; k < scene.meshes.size(); ++k) {
    if (scene.meshes[k].field.empty()) continue;
    const std::array<int, 3>& size = scene.volume.geometry().size;
    engine.set_field(static_cast<int>(k), {kVoxelCells, {{0, 0, 0}, size}, scene.meshes[k].field});
  }
  engine.set_points(scene.points);
}

Positions positions_of(Engine& engine, const TestScene& scene, int mesh) {
  Positions now(scene.meshes[mesh].mesh.positions.size()), before(now.size());
  engine.read(mesh, now, before);
  return now;
}

SimplexMesh mesh_of(Engine& engine, const TestScene& scene, int mesh) {
  return {positions_of(engine, scene, mesh), scene.meshes[mesh].mesh.neighbours};
}

Positions run(Engine& engine, const TestScene& scene, int steps) {
  load(engine, scene);
  const StepOutcome outcome = engine.step(steps);
  EXPECT_FALSE(outcome.failure.has_value()) << "after " << outcome.steps << " steps";
  EXPECT_EQ(outcome.steps, steps);
  Positions all;
  for (std::size_t k = 0; k < scene.meshes.size(); ++k) {
    const Positions one = positions_of(engine, scene, static_cast<int>(k));
    all.insert(all.end(), one.begin(), one.end());
  }
  return all;
}

SimplexMesh with_noise(SimplexMesh mesh, double sigma_mm, unsigned seed) {
  std::uint64_t counter = static_cast<std::uint64_t>(seed) << 40;
  for (Eigen::Vector3f& p : mesh.positions)
    for (int axis = 0; axis < 3; ++axis) {
      double sum = -6;  // sum of twelve uniform numbers minus 6: variance 1
      for (int draw = 0; draw < 12; ++draw) sum += uniform(counter++);
      p[axis] += static_cast<float>(sigma_mm * sum);
    }
  return mesh;
}

double largest_distance(const Positions& a, const Positions& b) {
  double largest = a.size() == b.size() ? 0 : INFINITY;
  for (std::size_t k = 0; k < a.size() && k < b.size(); ++k) {
    const double d = (a[k] - b[k]).cast<double>().norm();
    largest = std::isnan(d) ? INFINITY : std::max(largest, d);
  }
  return largest;
}

bool same_bits(const Positions& a, const Positions& b) {
  return a.size() == b.size() &&
         std::memcmp(static_cast<const void*>(a.data()), b.data(), a.size() * sizeof(a[0])) == 0;
}

bool all_finite(const Positions& positions) {
  return std::all_of(positions.begin(), positions.end(), [](const Eigen::Vector3f& p) { return p.allFinite(); });
}

double largest_radial_error(const Positions& positions, double radius_mm) {
  double largest = 0;
  for (const Eigen::Vector3f& p : positions) largest = std::max(largest, std::abs(p.cast<double>().norm() - radius_mm));
  return largest;
}

const Phantom& phantom(const std::string& kind, double contrast, double noise_sigma) {
  static std::map<std::tuple<std::string, double, double>, Phantom> made;
  const auto key = std::tuple(kind, contrast, noise_sigma);
  if (const auto found = made.find(key); found != made.end()) return found->second;
  PhantomSettings settings;
  settings.contrast = contrast, settings.background = contrast < 0 ? 150 : 50, settings.noise_sigma = noise_sigma;
  settings.type = VoxelType::Float32;
  return made.emplace(key, make_phantom(kind, settings)).first->second;
}

std::vector<std::uint16_t> ball_field(const VolumeGeometry& geometry, const Eigen::Vector3d& centre_mm,
                                      double radius_mm) {
  std::vector<std::uint16_t> field(geometry.voxel_count());
  std::size_t v = 0;
  for (int k = 0; k < geometry.size[2]; ++k)
    for (int j = 0; j < geometry.size[1]; ++j)
      for (int i = 0; i < geometry.size[0]; ++i, ++v) {
        const double depth = radius_mm - (geometry.world_from_index() * Eigen::Vector3d(i, j, k) - centre_mm).norm();
        field[v] = static_cast<std::uint16_t>(std::lround(65535 / (1 + std::exp(-depth))));
      }
  return field;
}

TestScene busy_scene(int level, double noise_sigma) {
  TestScene scene;
  scene.volume = phantom("sphere", 100, noise_sigma).image;
  TestMesh m;
  const SimplexMesh sphere = make_sphere({0.3, -0.2, 0.1}, kPhantomRadius, level);
  m.shape = shape_reference_of(sphere);
  m.profiles = profile_reference_of(sphere, scene.volume, m.forces);
  m.mesh = make_ellipsoid({0.7, 0.4, -0.5}, {17.6, 19.1, 20.9}, level);
  m.mesh = with_noise(std::move(m.mesh), 0.02 * measure(m.mesh).mean_edge_mm);
  m.region = estimate_region(scene.volume, m.mesh, 20);
  m.field = ball_field(scene.volume.geometry(), {0.5, 0, 0}, kPhantomRadius + 1);
  scene.meshes.push_back(std::move(m));
  scene.points = {{0, {23.1, 2.2, 1.3}}, {0, {-4.2, -14.1, 9.7}}};
  return scene;
}

}  // namespace simplexseg
