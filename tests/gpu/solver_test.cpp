// SPDX-License-Identifier: Apache-2.0
// Solvers: one fixed point, reached by each in its own time (docs/mathematics.md, section 3).
#include "core/solver.h"

#include <cmath>

#include "core/shape_reference.h"
#include "engine_fixture.h"

namespace simplexseg {
namespace {

class SolverTest : public EngineTest {
 protected:
  static SimulationParameters by(Solver solver) {
    SimulationParameters s = default_simulation_parameters();
    s.solver_choice = static_cast<float>(solver), s.refresh_interval = 1e6f;
    return s;
  }
  /// A linear problem: equal springs between neighbours, and to points beside every `each`-th vertex, or of one half.
  static TestScene membrane(int level, int each, bool half = true) {
    TestScene scene;
    scene.meshes.resize(1);
    TestMesh& m = scene.meshes[0];
    m.mesh = make_sphere({3, -2, 1}, 20, level);
    m.forces = with({{"smoothing", "weight", 5}, {"smoothing", "evenness", 0}, {"smoothing", "curvature", 0},
                     {"attraction", "weight", 0.5f}, {"attraction", "order", 0}});
    for (int i = 0; i < m.mesh.vertex_count(); i += each)
      if (!half || m.mesh.positions[i][2] > 1) scene.points.push_back({0, m.mesh.positions[i].cast<double>() + 0.1 * Eigen::Vector3d(std::sin(i), std::cos(i), std::sin(2 * i))});
    return scene;
  }
  /// Steps until the distance to `end`, root mean square, is `share` of what it was; `most` when it never is.
  static int steps_to(TestScene scene, Solver solver, const Positions& end, double share, int most) {
    scene.simulation = by(solver);
    if (solver == Solver::Verlet) scene.simulation.damping = 0.1f, scene.simulation.timestep = 10;
    const auto engine = make_engine();
    load(*engine, scene);
    auto distance = [&](const Positions& p) {
      double sum = 0;
      for (std::size_t k = 0; k < p.size(); ++k) sum += (p[k] - end[k]).cast<double>().squaredNorm();
      return std::sqrt(sum);
    };
    const double first = distance(scene.meshes[0].mesh.positions);
    for (int steps = 0; steps < most; steps += 5) {
      if (distance(positions_of(*engine, scene)) < share * first) return steps;
      EXPECT_FALSE(engine->step(5).failure.has_value());
    }
    return most;
  }
};
SIMPLEXSEG_ON_EVERY_BACKEND(SolverTest);

constexpr Solver kSolvers[] = {Solver::Automatic, Solver::Verlet, Solver::Damped, Solver::Multigrid};

TEST_P(SolverTest, AllReachTheSameFixedPoint) {
  TestScene scene = membrane(2, 3);
  Positions first;
  for (Solver solver : kSolvers) {
    scene.simulation = by(solver);
    const Positions end = run(scene, 3000);
    if (first.empty()) first = end;
    EXPECT_LT(largest_distance(end, first), 1e-4) << static_cast<int>(solver);
  }
  EXPECT_GT(largest_distance(first, scene.meshes[0].mesh.positions), 1);
}

TEST_P(SolverTest, EachTakesFewerStepsThanTheOneBefore) {
  const TestScene scene = membrane(4, 1, false);
  TestScene exact = scene;
  exact.simulation = by(Solver::Multigrid);
  const Positions end = run(exact, 1000);
  const int verlet = steps_to(scene, Solver::Verlet, end, 0.01, 4000), damped = steps_to(scene, Solver::Damped, end, 0.01, 4000);
  const int multigrid = steps_to(scene, Solver::Multigrid, end, 0.01, 4000);
  EXPECT_LT(verlet, 4000);
  EXPECT_LT(damped, 0.8 * verlet);
  EXPECT_LT(multigrid, 0.6 * damped);
  EXPECT_LE(steps_to(scene, Solver::Automatic, end, 0.01, 4000), damped);
  // Slow modes, of the half that nothing holds, are what the cycle is for.
  TestScene half = membrane(4, 1);
  half.simulation = by(Solver::Multigrid);
  const Positions half_end = run(half, 1000);
  EXPECT_LT(10 * steps_to(half, Solver::Multigrid, half_end, 0.01, 4000), steps_to(half, Solver::Verlet, half_end, 0.01, 4000));
}

TEST_P(SolverTest, TheCycleTakesAsManyStepsOnFineMeshesAsOnCoarseOnes) {
  int steps[2];
  for (int level : {3, 5}) {
    TestScene scene = membrane(level, 1);
    // As many springs to points on each level, of one strength in all.
    weight_of(scene.meshes[0].forces, ForceId::Attraction) = level == 3 ? 0.5f : 0.5f / 16;
    scene.simulation = by(Solver::Multigrid);
    const Positions end = run(scene, 400);
    steps[level == 5] = steps_to(scene, Solver::Multigrid, end, 0.01, 400);
  }
  EXPECT_LE(steps[1], 2 * steps[0] + 10) << steps[0] << " with 1280 vertices, " << steps[1] << " with 20480";
}

TEST_P(SolverTest, WhatItLearnsDoesNotDependOnHowManyStepsAreAskedForAtOnce) {
  for (Solver solver : {Solver::Automatic, Solver::Damped, Solver::Multigrid}) {
    TestScene scene = busy_scene(3);
    for (const ForceInfo& force : force_list()) weight_of(scene.meshes[0].forces, force.id) = 0.3f;
    scene.simulation = by(solver);
    scene.simulation.refresh_interval = 3;
    const Positions whole = run(scene, 60);
    const auto engine = make_engine();
    load(*engine, scene);
    for (int steps : {1, 2, 7, 13, 9, 1, 1, 26}) engine->step(steps);
    EXPECT_TRUE(same_bits(positions_of(*engine, scene), whole)) << static_cast<int>(solver);
  }
}

TEST_P(SolverTest, AMeshWithoutTheCycleBesideOneWithItIsMeasuredAndLearntAsAlone) {
  TestScene alone = busy_scene(3), with_cycle = membrane(3, 2);
  alone.points.clear();
  for (const ForceInfo& force : force_list())
    weight_of(alone.meshes[0].forces, force.id) = force.id == ForceId::Gradient || force.id == ForceId::Region ? 0.3f : 0.0f;
  TestScene both = with_cycle;
  both.volume = alone.volume;
  both.meshes.push_back(alone.meshes[0]);
  auto outcome_of = [&](TestScene& scene, std::initializer_list<int> batches) {
    scene.simulation = by(Solver::Multigrid);
    scene.simulation.refresh_interval = 4;
    const auto engine = make_engine();
    load(*engine, scene);
    StepOutcome outcome;
    for (int steps : batches) outcome = engine->step(steps);
    return outcome;
  };
  const StepOutcome a = outcome_of(alone, {14}), b = outcome_of(both, {14}), c = outcome_of(both, {3, 9, 2}), d = outcome_of(with_cycle, {14});
  EXPECT_GT(a.residual_mm.at(0), 1e-4);
  EXPECT_GT(a.solver.at(0).slowest, 0);
  EXPECT_NEAR(b.residual_mm.at(1), a.residual_mm.at(0), 1e-3 * a.residual_mm.at(0));
  EXPECT_NEAR(b.solver.at(1).slowest, a.solver.at(0).slowest, 1e-3 * a.solver.at(0).slowest);
  EXPECT_EQ(c.residual_mm.at(1), b.residual_mm.at(1));
  EXPECT_EQ(c.solver.at(1).slowest, b.solver.at(1).slowest);
  EXPECT_NEAR(b.residual_mm.at(0), d.residual_mm.at(0), 1e-3 * d.residual_mm.at(0));
}

TEST_P(SolverTest, WhatWasLearntGoesOnAfterALoad) {
  TestScene scene = membrane(4, 2);
  scene.simulation = by(Solver::Damped);
  const auto engine = make_engine();
  load(*engine, scene);
  const SolverState learnt = engine->step(100).solver.at(0);
  EXPECT_GT(learnt.slowest, 0);
  EngineMesh m;
  const TestMesh& t = scene.meshes[0];
  m.positions = m.previous = t.mesh.positions, m.neighbours = t.mesh.neighbours, m.parameters = t.forces, m.solver = learnt;
  engine->load(std::span(&m, 1), scene.simulation);
  EXPECT_EQ(engine->step(1).solver.at(0).slowest, learnt.slowest);
  // New weights: it is to be learnt again.
  const std::vector<ForceParameters> same{t.forces};
  engine->set_parameters(same, scene.simulation);
  EXPECT_NE(engine->step(1).solver.at(0).slowest, learnt.slowest);
}

TEST_P(SolverTest, EveryForceAndAllTogetherStayBoundedWithEverySolver) {
  for (Solver solver : kSolvers) {
    TestScene scene = busy_scene(3, 10);
    for (const ForceInfo& force : force_list()) weight_of(scene.meshes[0].forces, force.id) = force.parameters[0].maximum;
    scene.simulation = by(solver);
    scene.simulation.refresh_interval = 3;
    const Positions end = run(scene, 300);
    double farthest = 0;
    for (const Eigen::Vector3f& p : end) farthest = std::max(farthest, static_cast<double>(p.norm()));
    EXPECT_LT(farthest, 60) << static_cast<int>(solver);
  }
}

TEST_P(SolverTest, FoldsAndMeshesInsideOutAreSeen) {
  // Sound spheres are told from folded ones, and from those turned inside out.
  TestScene scene = busy_scene(3);
  scene.simulation = simulation(1, 1);
  const auto engine = make_engine();
  load(*engine, scene);
  StepOutcome outcome = engine->step(1);
  EXPECT_EQ(outcome.folded_vertices.at(0), 0);
  EXPECT_FALSE(outcome.inside_out.at(0));
  for (Eigen::Vector3f& p : scene.meshes[0].mesh.positions) p[0] = -p[0];
  load(*engine, scene);
  outcome = engine->step(1);
  EXPECT_TRUE(outcome.inside_out.at(0));
  scene = busy_scene(3);
  scene.meshes[0].mesh.positions[5] *= 0.5f;
  load(*engine, scene);
  EXPECT_GT(engine->step(1).folded_vertices.at(0), 0);
}

}  // namespace
}  // namespace simplexseg
