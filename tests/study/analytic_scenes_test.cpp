// SPDX-License-Identifier: Apache-2.0
// Comparison of the engines with exact solutions: order of the Verlet integrator, and a fixed point.
#include "study/analytic_scenes.h"

#include <cmath>

#include "step/simulation_parameters.h"
#include "study/fixed_point.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

class AnalyticScenes : public EngineTest {
 protected:
  static std::unique_ptr<Engine> load(const AnalyticScene& scene, double before, double damping_rate,
                                      SimulationParameters simulation) {
    TestScene s;
    s.meshes.resize(1);
    s.meshes[0].mesh = scene.mesh, s.meshes[0].forces = scene.forces;
    if (scene.exact) s.meshes[0].previous = positions_of(scene.exact(-before, damping_rate));
    for (const Eigen::Vector3d& p : scene.points_mm) s.points.push_back({0, p});
    s.simulation = simulation;
    auto engine = make_engine();
    simplexseg::load(*engine, s);
    return engine;
  }
  static Pose pose_of_engine(Engine& engine, const AnalyticScene& scene) {
    Positions now(scene.mesh.positions.size()), before(now.size());
    engine.read(0, now, before);
    return pose_of(now);
  }
  /// Largest distance (mm) of a vertex from its exact position at the time `end`, after `steps` steps.
  static double error(const AnalyticScene& scene, Solver solver, double end, int steps, double damping_rate) {
    const double dt = end / steps;
    // The refresh interval exceeds the number of steps, so each attraction point stays bound to its first vertex.
    SimulationParameters s = simulation(static_cast<float>(dt), static_cast<float>(damping_rate * dt), 1000);
    s.solver_choice = static_cast<float>(solver);
    const auto engine = load(scene, dt, damping_rate, s);
    EXPECT_FALSE(engine->step(steps).failure.has_value());
    return (pose_of_engine(*engine, scene) - scene.exact(end, damping_rate)).colwise().norm().maxCoeff();
  }
  static double order(const AnalyticScene& scene, Solver solver, double damping_rate, int coarsest = 40) {
    const double end = 8;
    std::vector<double> timesteps, errors;
    for (int steps : {coarsest, 2 * coarsest, 4 * coarsest}) {
      timesteps.push_back(end / steps);
      errors.push_back(error(scene, solver, end, steps, damping_rate));
      EXPECT_GT(errors.back(), 1e-4) << "float rounding (1e-6 mm per step) would dominate the error of the method";
    }
    return measured_order(timesteps, errors);
  }
};
SIMPLEXSEG_ON_EVERY_BACKEND(AnalyticScenes);

// The undamped scheme x(t + dt) - 2 x(t) + x(t - dt) = dt^2 a is of order 2. The damping term c (x(t) - x(t - dt)) / dt
// uses the velocity half a step earlier, which reduces the order to 1.
TEST_P(AnalyticScenes, VerletIsOfSecondOrderUndampedAndOfFirstDamped) {
  for (const AnalyticScene& scene : {oscillator_scene(1.5), sphere_relaxation_scene(4)}) {
    EXPECT_NEAR(order(scene, Solver::Verlet, 0), 2, 0.2) << scene.name;
    EXPECT_NEAR(order(scene, Solver::Verlet, 0.3), 1, 0.2) << scene.name;
  }
}

TEST_P(AnalyticScenes, TheSpringMeshEndsAtItsSolution) {
  const AnalyticScene scene = spring_mesh_scene();
  const auto engine = load(scene, 0, 0, limited(1, 0.2f, 1000000));
  EXPECT_FALSE(engine->step(2000).failure.has_value());
  EXPECT_LT((pose_of_engine(*engine, scene) - scene.fixed_point).colwise().norm().maxCoeff(), 1e-4);
  EXPECT_GT((pose_of(scene.mesh.positions) - scene.fixed_point).colwise().norm().minCoeff(), 0.01);
}

TEST(AnalyticSolutions, TheFixedPointOfTheSpringMeshIsTheModels) {
  const AnalyticScene scene = spring_mesh_scene();
  const Pose start = pose_of(scene.mesh.positions);
  ReferenceScene s;
  s.neighbours = scene.mesh.neighbours, s.forces = scene.forces, s.points_mm = scene.points_mm;
  const ReferenceModel model(s, start);
  EXPECT_LT(model.acceleration(scene.fixed_point).norm(), 1e-9);
  const FixedPoint found = find_fixed_point(model, start);
  EXPECT_TRUE(found.converged);
  EXPECT_LT((found.pose - scene.fixed_point).colwise().norm().maxCoeff(), 1e-8);
}

TEST(AnalyticSolutions, TheSolutionSatisfiesItsEquation) {
  const double h = 1e-4;
  for (double c : {0.0, 0.3, 2 * std::sqrt(1.5), 4.0})
    for (double t : {-0.2, 0.0, 1.7}) {
      const double before = damped_oscillation(1.5, c, t - h), x = damped_oscillation(1.5, c, t),
                   after = damped_oscillation(1.5, c, t + h);
      EXPECT_NEAR((after - 2 * x + before) / (h * h) + c * (after - before) / (2 * h) + 1.5 * x, 0, 1e-6);
    }
  EXPECT_DOUBLE_EQ(damped_oscillation(1.5, 0.3, 0), 1);
}

}  // namespace
}  // namespace simplexseg
