// SPDX-License-Identifier: Apache-2.0
// What the engine's tests share: scenes at the level of the engine, and a fixture that runs on every backend.
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

/// One assignment "force.parameter" = value; fails the test when there is no such parameter.
struct Setting {
  const char* force;
  const char* parameter;
  float value;
};
void set(ForceParameters& forces, const Setting& setting);
/// All weights 0, every other parameter at a value of the tests' own: the defaults are free to change.
ForceParameters weightless();
ForceParameters with(std::initializer_list<Setting> settings);
/// "smoothing" -> its weight.
float& weight_of(ForceParameters& forces, ForceId force);

/// Verlet, timestep limit off, targets refreshed at every step.
SimulationParameters simulation(float timestep, float damping, int refresh_interval = 1);
/// The same with the timestep limit on.
SimulationParameters limited(float timestep, float damping, int refresh_interval = 1);

struct TestMesh {
  SimplexMesh mesh;
  ForceParameters forces = weightless();
  Positions previous;  ///< empty: at rest
  std::vector<Vec4> shape;
  std::vector<float> profiles;
  RegionModel region;
  std::vector<std::uint16_t> field;  ///< P(object) on the whole volume; empty: none
  bool finest = true;
};
struct TestScene {
  Volume volume;
  std::vector<TestMesh> meshes;
  std::vector<EnginePoint> points;
  SimulationParameters simulation = simplexseg::simulation(1, 1);
};
/// As an engine is loaded with them; they refer to the scene.
std::vector<EngineMesh> engine_meshes(const TestScene& scene);
void load(Engine& engine, const TestScene& scene);
/// Positions of a mesh now.
Positions positions_of(Engine& engine, const TestScene& scene, int mesh = 0);
SimplexMesh mesh_of(Engine& engine, const TestScene& scene, int mesh = 0);
/// Loads, takes the steps, fails the test when one fails; positions of mesh 0 or, by default, of all meshes in a row.
Positions run(Engine& engine, const TestScene& scene, int steps);

/// The same mesh with Gaussian noise of `sigma_mm` on every coordinate; the same on every machine.
SimplexMesh with_noise(SimplexMesh mesh, double sigma_mm, unsigned seed = 1);

double largest_distance(const Positions& a, const Positions& b);
bool same_bits(const Positions& a, const Positions& b);
bool all_finite(const Positions& positions);
/// Largest | |p| - radius |, mm.
double largest_radial_error(const Positions& positions, double radius_mm);

/// A float32 phantom of 64^3 voxels of 1 mm, made once for each kind and contrast. The sphere has a radius of 19.2 mm.
const Phantom& phantom(const std::string& kind, double contrast = 100, double noise_sigma = 0);
inline constexpr double kPhantomRadius = 19.2;

/// P(object) of a ball: falls from 1 to 0 over a few mm about its surface. 0 to 65535, of all voxels.
std::vector<std::uint16_t> ball_field(const VolumeGeometry& geometry, const Eigen::Vector3d& centre_mm,
                                      double radius_mm);

/// A scene in which every force acts: a deformed sphere near the edge of the sphere phantom, with all references and
/// two attraction points. All weights are 0.
TestScene busy_scene(int level = 3, double noise_sigma = 0);

/// Every test runs on the CPU and, where a device is, on CUDA.
class EngineTest : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == "cuda" && !why_no_cuda().empty())
      GTEST_SKIP() << "skipped: no CUDA device (" << why_no_cuda() << ")";
  }
  static std::unique_ptr<Engine> make_engine() { return GetParam() == "cuda" ? make_cuda_engine() : make_cpu_engine(); }
  static Positions run(const TestScene& scene, int steps) { return simplexseg::run(*make_engine(), scene, steps); }
};
#define SIMPLEXSEG_ON_EVERY_BACKEND(Suite)                                    \
  INSTANTIATE_TEST_SUITE_P(Backends, Suite, ::testing::Values("cpu", "cuda"), \
                           [](const auto& info) { return std::string(info.param); })

}  // namespace simplexseg
