// SPDX-License-Identifier: Apache-2.0
// Comparison of the stability bound (docs/mathematics.md, section 3) with the engine.
#include "step/stability.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mesh/mesh_geometry.h"
#include "step/simulation_parameters.h"
#include "study/stability_limits.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

class StabilityTest : public EngineTest {};
SIMPLEXSEG_ON_EVERY_BACKEND(StabilityTest);

TEST_P(StabilityTest, EveryForceIsStableUpToItsBound) {
  for (const LimitProblem& problem : limit_problems())
    for (const double damping : kLimitDampings) {
      const double predicted = predicted_limit(problem, damping);
      const StabilityLimit limit{problem.name, damping, predicted, measured_limit(problem, damping, make_engine)};
      EXPECT_TRUE(limit.as_predicted()) << problem.name << ", damping " << damping << ": " << limit.measured
                                        << " measured, " << predicted << " predicted";
    }
}

TEST_P(StabilityTest, EvenSmoothingIsStableWithinItsBound) {
  // With weights that follow the edge lengths, the bound is that of the worst mesh; on a sphere the stiffness is
  // (2 + a) k.
  TestScene scene;
  scene.meshes.resize(1);
  TestMesh& m = scene.meshes[0];
  m.mesh = with_noise(make_sphere({0, 0, 0}, 20, 3), 0.001);
  for (float evenness : {1.0f, 2.0f, 4.0f}) {
    m.forces =
        with({{"smoothing", "weight", 0.8f}, {"smoothing", "evenness", evenness}, {"smoothing", "elevation_limit", 2}});
    const double predicted = stable_timestep(stiffness_bound(m.forces, {}), 0.9f);
    const double on_sphere = std::sqrt(2.2 / (0.8 * (2 + evenness)));
    EXPECT_LE(predicted, 1.025 * on_sphere);
    auto last_move = [&](double timestep) {
      scene.simulation = simulation(static_cast<float>(timestep), 0.9f);
      const auto engine = make_engine();
      load(*engine, scene);
      const StepOutcome outcome = engine->step(600);
      return outcome.failure ? INFINITY : outcome.mean_move_mm[0];
    };
    EXPECT_LT(last_move(0.98 * std::min(predicted, on_sphere)), 1e-3) << "evenness " << evenness;
    EXPECT_GT(last_move(1.05 * on_sphere), 1e-2) << "evenness " << evenness;
  }
}

/// Attraction of one vertex to a point at a distance of 0.01 mm.
TestScene one_oscillator(float weight) {
  TestScene scene;
  scene.meshes.resize(1);
  TestMesh& m = scene.meshes[0];
  m.mesh = make_sphere({0, 0, 0}, 20, 2);
  m.forces = with({{"attraction", "weight", weight}, {"attraction", "order", 0}});
  scene.points = {{0, 1.0005 * m.mesh.positions[7].cast<double>()}};
  return scene;
}

TEST_P(StabilityTest, AnUndampedModeHasThePeriodOfTheDiscreteOscillator) {
  for (double stiffness : {0.05, 0.4, 2.0}) {  // k dt^2
    TestScene scene = one_oscillator(static_cast<float>(stiffness));
    const Eigen::Vector3d c = scene.points[0].position_mm, start = scene.meshes[0].mesh.positions[7].cast<double>() - c;
    scene.simulation = simulation(1, 0);
    const auto engine = make_engine();
    load(*engine, scene);
    // x+ - 2x + x- = -k dt^2 x with zero initial velocity: x_n = x_0 cos(omega (n + 1/2)) / cos(omega / 2), where
    // cos(omega) = 1 - k dt^2 / 2.
    const double omega = std::acos(1 - 0.5 * stiffness);
    double worst = 0;
    for (int n = 1; n <= 150; ++n) {
      engine->step(1);
      const double x = (positions_of(*engine, scene)[7].cast<double>() - c).dot(start) / start.squaredNorm();
      worst = std::max(worst, std::abs(x - std::cos(omega * (n + 0.5)) / std::cos(0.5 * omega)));
    }
    EXPECT_LT(worst, 0.05) << "k dt^2 = " << stiffness;  // float positions resolve 2e-4 of the amplitude
  }
}

TEST_P(StabilityTest, AModeHasThePeriodOfItsMassAndItsShareOfTheForce) {
  constexpr double kStiffness = 0.1;  // k dt^2
  double smallest = 1, largest = 1;
  for (const int vertex : {7, 40})
    for (const auto& [in_mass, in_force] : {std::pair{1.0f, 0.0f}, {0.0f, 1.0f}, {0.5f, 1.0f}, {1.0f, 1.0f}}) {
      TestScene scene = one_oscillator(static_cast<float>(kStiffness));
      SimplexMesh& mesh = scene.meshes[0].mesh;
      for (Eigen::Vector3f& p : mesh.positions) p = {p[0], p[1], 3 * p[2]};
      const Eigen::Vector3d c = 1.0005 * mesh.positions[vertex].cast<double>();
      scene.points[0].position_mm = c;
      scene.simulation = simulation(1, 0);
      scene.simulation.area_in_mass = in_mass, scene.simulation.area_in_force = in_force;
      const auto& nb = mesh.neighbours[vertex];
      const auto corner = [&](int k) { return mesh.positions[nb[k]].cast<double>().eval(); };
      const double area = 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm(),
                   edge = mean_edge_mm(mesh.positions, mesh.neighbours),
                   relative = std::clamp(area / (0.75 * std::sqrt(3.0) * edge * edge), 0.25, 4.0);
      const double factor = (1 + in_force * (relative - 1)) / (1 + in_mass * (relative - 1));
      smallest = std::min(smallest, factor), largest = std::max(largest, factor);
      const Eigen::Vector3d start = mesh.positions[vertex].cast<double>() - c;
      const auto engine = make_engine();
      load(*engine, scene);
      const double omega = std::acos(1 - 0.5 * factor * kStiffness);
      double worst = 0;
      for (int n = 1; n <= 100; ++n) {
        engine->step(1);
        const double x = (positions_of(*engine, scene)[vertex].cast<double>() - c).dot(start) / start.squaredNorm();
        worst = std::max(worst, std::abs(x - std::cos(omega * (n + 0.5)) / std::cos(0.5 * omega)));
      }
      EXPECT_LT(worst, 0.05) << "vertex " << vertex << ", shares " << in_mass << " and " << in_force << ", factor "
                             << factor;
    }
  EXPECT_LT(smallest, 0.7);
  EXPECT_GT(largest, 1.4);
}

TEST_P(StabilityTest, TheLimitIncludesAreasAndMasses) {
  // Relative to an edge of three times its mean, all areas are at their lower limit, and all masses are 1/4; relative
  // to a third of it, all areas are at their upper limit, and all forces are fourfold.
  for (const bool light : {true, false}) {
    EngineMesh m;
    SimplexMesh mesh = with_noise(make_sphere({0, 0, 0}, 20, 2), 0.01);
    m.positions = m.previous = mesh.positions, m.neighbours = mesh.neighbours;
    m.parameters = with({{"smoothing", "weight", 1}, {"smoothing", "evenness", 0}, {"smoothing", "curvature", 0}});
    m.edge_mm = mean_edge_mm(mesh.positions, mesh.neighbours) * (light ? 3.0f : 1.0f / 3);
    const float stiffness = stiffness_bound(m.parameters, {});
    const auto grows = [&](float timestep, bool limit) {
      SimulationParameters s = limit ? limited(timestep, 0.2f) : simulation(timestep, 0.2f);
      (light ? s.area_in_mass : s.area_in_force) = 1;
      const auto engine = make_engine();
      engine->load(std::span(&m, 1), s);
      const StepOutcome outcome = engine->step(60);
      return outcome.failure || !outcome.cuts.empty() || outcome.mean_move_mm[0] > 1;
    };
    EXPECT_FALSE(grows(10, true)) << "light " << light;
    EXPECT_TRUE(grows(0.9f * stable_timestep(stiffness, 0.2f), false)) << "the limit of unit masses, light " << light;
  }
}

TEST_P(StabilityTest, TheLimitKeepsExtremeWeightsBounded) {
  for (float damping : {0.1f, 0.9f})
    for (float timestep : {1.0f, 10.0f}) {
      TestScene scene = busy_scene(3, 10);
      for (const ForceInfo& force : force_list())
        weight_of(scene.meshes[0].forces, force.id) = force.parameters[0].maximum;
      scene.simulation = limited(timestep, damping, 3);
      const Positions end = run(scene, 500);
      double farthest = 0;
      for (const Eigen::Vector3f& p : end) farthest = std::max(farthest, static_cast<double>(p.norm()));
      EXPECT_LT(farthest, 60) << "damping " << damping << ", timestep "
                              << timestep;  // the volume's corners lie at 55 mm
    }
}

TEST_P(StabilityTest, TheLimitIsNineTenthsOfTheBound) {
  SimulationParameters s = limited(10, 0.3f);
  EXPECT_NEAR(effective_timestep(s, 2), 0.9 * std::sqrt(3.4 / 2), 1e-6);
  s.timestep = 0.1f;
  EXPECT_EQ(effective_timestep(s, 2), 0.1f);
  s.timestep = 10, s.limit_timestep = 0;
  EXPECT_EQ(effective_timestep(s, 2), 10);
  EXPECT_TRUE(std::isinf(stable_timestep(0, 0.3f)));
  // A mass is at least 0.25, a force at most fourfold.
  s = limited(10, 0.3f);
  s.area_in_mass = 1;
  EXPECT_NEAR(effective_timestep(s, 2), 0.9 * std::sqrt(3.4 / 8), 1e-6);
  s.area_in_mass = 0, s.area_in_force = 0.5f;
  EXPECT_NEAR(effective_timestep(s, 2), 0.9 * std::sqrt(3.4 / 5), 1e-6);
  s.area_in_mass = 0.5f;
  EXPECT_NEAR(effective_timestep(s, 2), 0.9 * std::sqrt(3.4 / 2), 1e-6);
}

}  // namespace
}  // namespace simplexseg
