// SPDX-License-Identifier: Apache-2.0
// Common parts of the tests of the engine: scenes for the engine, and a fixture that runs on every backend.
#pragma once
#include <gtest/gtest.h>

#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "forces/parameters.h"
#include "forces/profile_reference.h"
#include "forces/region_model.h"
#include "gpu/backend.h"
#include "image/volume.h"
#include "mesh/simplex_mesh.h"
#include "step/engine.h"
#include "step/simulation_parameters.h"
#include "study/phantom.h"

namespace simplexseg {

using Positions = std::vector<Eigen::Vector3f>;

/// Assignment of a value to the parameter "force.parameter"; set() fails the test if the parameter does not exist.
struct Setting {
  const char* force;
  const char* parameter;
  float value;
};
void set(ForceParameters& forces, const Setting& setting);
/// Parameters with all weights 0 and fixed values for the tests, independent of the defaults.
ForceParameters weightless();
ForceParameters with(std::initializer_list<Setting> settings);
/// Reference to the weight of a force.
float& weight_of(ForceParameters& forces, ForceId force);

/// Default settings with Verlet and the timestep limit off. `refresh_interval`: steps between target refreshes; 1: at
/// every step.
SimulationParameters simulation(float timestep, float damping, int refresh_interval = 1);
/// Settings of simulation() with the timestep limit on.
SimulationParameters limited(float timestep, float damping, int refresh_interval = 1);

struct TestMesh {
  SimplexMesh mesh;
  ForceParameters forces = weightless();
  Positions previous;  ///< positions one step earlier; empty: zero velocity
  std::vector<Vec4> shape;
  std::vector<float> profiles;
  RegionModel region;
  std::vector<std::uint16_t> field;  ///< field on the whole volume; empty: no field
  bool finest = true;
};
struct TestScene {
  Volume volume;
  std::vector<TestMesh> meshes;
  std::vector<EnginePoint> points;
  SimulationParameters simulation = simplexseg::simulation(1, 1);
};
/// Meshes for Engine::load(). The spans refer to `scene`, which must outlive them.
std::vector<EngineMesh> engine_meshes(const TestScene& scene);
void load(Engine& engine, const TestScene& scene);
/// Current positions of a mesh, mm.
Positions positions_of(Engine& engine, const TestScene& scene, int mesh = 0);
SimplexMesh mesh_of(Engine& engine, const TestScene& scene, int mesh = 0);
/// Loads the scene and runs the steps; fails the test if a step fails. Returns the final positions of all meshes,
/// concatenated.
Positions run(Engine& engine, const TestScene& scene, int steps);

/// Adds approximately Gaussian noise of standard deviation `sigma_mm` to every coordinate, reproducible on every
/// machine.
SimplexMesh with_noise(SimplexMesh mesh, double sigma_mm, unsigned seed = 1);

double largest_distance(const Positions& a, const Positions& b);
bool same_bits(const Positions& a, const Positions& b);
bool all_finite(const Positions& positions);
/// Largest | |p| - radius | over the positions p, mm.
double largest_radial_error(const Positions& positions, double radius_mm);

/// Cached float32 phantom of 64^3 voxels of 1 mm. The phantom "sphere" has a radius of 19.2 mm.
const Phantom& phantom(const std::string& kind, double contrast = 100, double noise_sigma = 0);
inline constexpr double kPhantomRadius = 19.2;

/// Foreground probability field of a ball on all voxels: values from 0 to 65535, which stand for 0 to 1 and fall to 0
/// within a few mm of the surface.
std::vector<std::uint16_t> ball_field(const VolumeGeometry& geometry, const Eigen::Vector3d& centre_mm,
                                      double radius_mm);

/// Scene in which every force can act: a deformed sphere near the surface of the sphere phantom, with all references
/// and two attraction points. All weights are 0; the caller sets those of the tested forces.
TestScene busy_scene(int level = 3, double noise_sigma = 0);

/// Runs every test on the CPU and, if a CUDA device is available, on CUDA.
class EngineTest : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == "cuda" && !cuda_unavailable_reason().empty())
      GTEST_SKIP() << "skipped: no CUDA device (" << cuda_unavailable_reason() << ")";
  }
  static std::unique_ptr<Engine> make_engine() { return GetParam() == "cuda" ? make_cuda_engine() : make_cpu_engine(); }
  static Positions run(const TestScene& scene, int steps) { return simplexseg::run(*make_engine(), scene, steps); }
};
#define SIMPLEXSEG_ON_EVERY_BACKEND(Suite)                                    \
  INSTANTIATE_TEST_SUITE_P(Backends, Suite, ::testing::Values("cpu", "cuda"), \
                           [](const auto& info) { return std::string(info.param); })

}  // namespace simplexseg
