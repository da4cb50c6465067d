// SPDX-License-Identifier: Apache-2.0
// All solvers reach the same fixed point, in different numbers of steps (docs/mathematics.md, section 3).
#include "step/solver.h"

#include <Eigen/Dense>
#include <cmath>

#include "gpu/vertex_order.h"
#include "mesh/hierarchy.h"
#include "mesh/shape_reference.h"
#include "step/simulation_parameters.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

class SolverTest : public EngineTest {
 protected:
  static SimulationParameters by(Solver solver) {
    SimulationParameters s = default_simulation_parameters();
    s.solver_choice = static_cast<float>(solver), s.refresh_interval = 1e6f;
    return s;
  }
  /// Linear problem: equal springs between neighbours, and to points near every `every`-th vertex of the whole or half
  /// mesh.
  static TestScene membrane(int level, int every, bool half = true) {
    TestScene scene;
    scene.meshes.resize(1);
    TestMesh& m = scene.meshes[0];
    m.mesh = make_sphere({3, -2, 1}, 20, level);
    m.forces = with({{"smoothing", "weight", 5},
                     {"smoothing", "evenness", 0},
                     {"smoothing", "curvature", 0},
                     {"attraction", "weight", 0.5f},
                     {"attraction", "order", 0}});
    for (int i = 0; i < m.mesh.vertex_count(); i += every)
      if (!half || m.mesh.positions[i][2] > 1)
        scene.points.push_back(
            {0, m.mesh.positions[i].cast<double>() + 0.1 * Eigen::Vector3d(std::sin(i), std::cos(i), std::sin(2 * i))});
    return scene;
  }
  /// Steps until the root mean square distance to `end` is `share` of the initial one, at most `max_steps`.
  static int steps_to(TestScene scene, Solver solver, const Positions& end, double share, int max_steps) {
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
    for (int steps = 0; steps < max_steps; steps += 5) {
      if (distance(positions_of(*engine, scene)) < share * first) return steps;
      EXPECT_FALSE(engine->step(5).failure.has_value());
    }
    return max_steps;
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

TEST_P(SolverTest, EachNeedsFewerStepsThanThePreviousOne) {
  const TestScene scene = membrane(4, 1, false);
  TestScene exact = scene;
  exact.simulation = by(Solver::Multigrid);
  const Positions end = run(exact, 1000);
  const int verlet = steps_to(scene, Solver::Verlet, end, 0.01, 4000),
            damped = steps_to(scene, Solver::Damped, end, 0.01, 4000);
  const int multigrid = steps_to(scene, Solver::Multigrid, end, 0.01, 4000);
  EXPECT_LT(verlet, 4000);
  EXPECT_LT(damped, 0.8 * verlet);
  EXPECT_LT(multigrid, 0.6 * damped);
  EXPECT_LE(steps_to(scene, Solver::Automatic, end, 0.01, 4000), damped);
  // The cycle accelerates slow modes: here those of the unconstrained half.
  TestScene half = membrane(4, 1);
  half.simulation = by(Solver::Multigrid);
  const Positions half_end = run(half, 1000);
  EXPECT_LT(10 * steps_to(half, Solver::Multigrid, half_end, 0.01, 4000),
            steps_to(half, Solver::Verlet, half_end, 0.01, 4000));
}

TEST_P(SolverTest, TheCycleNeedsAsManyStepsOnFineMeshesAsOnCoarseOnes) {
  int steps[2];
  for (int level : {3, 5}) {
    TestScene scene = membrane(level, 1);
    // The number of springs to points and their total strength are equal on all levels.
    weight_of(scene.meshes[0].forces, ForceId::Attraction) = level == 3 ? 0.5f : 0.5f / 16;
    scene.simulation = by(Solver::Multigrid);
    const Positions end = run(scene, 400);
    steps[level == 5] = steps_to(scene, Solver::Multigrid, end, 0.01, 400);
  }
  EXPECT_LE(steps[1], 2 * steps[0] + 10) << steps[0] << " with 1280 vertices, " << steps[1] << " with 20480";
}

/// V-cycle of docs/mathematics.md, section 3, in double, for a model A = k L + E with a scalar E for each vertex.
/// Vertices are aggregated in the order of the engine.
class DenseCycle {
 public:
  DenseCycle(const SimplexMesh& mesh, double k, const std::vector<double>& stiffness)
      : order_(patch_order(mesh.neighbours)) {
    const int n = mesh.vertex_count();
    std::vector<int> place(n);
    for (int i = 0; i < n; ++i) place[order_[i]] = i;
    std::vector<std::array<int, 3>> neighbours(n);
    std::vector<double> e(n);
    Eigen::MatrixXd graph = Eigen::MatrixXd::Zero(n, n);
    for (int i = 0; i < n; ++i) {
      e[i] = stiffness[order_[i]];
      for (int s = 0; s < 3; ++s) {
        const int j = neighbours[i][s] = place[mesh.neighbours[order_[i]][s]];
        graph(i, i) += 1.0 / 3, graph(i, j) -= 1.0 / 3;
      }
    }
    hierarchy_ = make_hierarchy(neighbours);
    add_level(k * graph, e);
    for (const Hierarchy::Level& level : hierarchy_.levels) {
      graph = Eigen::MatrixXd::Zero(level.size(), level.size());
      std::vector<double> sums(level.size());
      for (int i = 0; i < level.size(); ++i) {
        for (int p = level.part_first[i]; p < level.part_first[i + 1]; ++p) sums[i] += e[level.parts[p]];
        for (int c = level.edge_first[i]; c < level.edge_first[i + 1]; ++c)
          graph(i, i) += level.edges[c].conductance, graph(i, level.edges[c].to) -= level.edges[c].conductance;
      }
      e = sums;
      add_level(k * graph, e);
    }
  }
  Eigen::VectorXd operator()(const Eigen::VectorXd& f) const {
    Eigen::VectorXd ordered(f.size()), z(f.size());
    for (int i = 0; i < f.size(); ++i) ordered[i] = f[order_[i]];
    ordered = solve(0, ordered);
    for (int i = 0; i < f.size(); ++i) z[order_[i]] = ordered[i];
    return z;
  }

 private:
  void add_level(const Eigen::MatrixXd& laplacian, const std::vector<double>& e) {
    systems_.push_back(
        laplacian +
        Eigen::MatrixXd(Eigen::Map<const Eigen::VectorXd>(e.data(), static_cast<long>(e.size())).asDiagonal()));
  }
  Eigen::VectorXd solve(std::size_t l, const Eigen::VectorXd& f) const {
    const Eigen::MatrixXd& a = systems_[l];
    if (l + 1 == systems_.size()) return a.diagonal().cwiseInverse().asDiagonal() * f;  // one vertex
    const Eigen::VectorXd relax = 0.7 * a.diagonal().cwiseInverse();
    Eigen::VectorXd z = relax.cwiseProduct(f);
    const Hierarchy::Level& level = hierarchy_.levels[l];
    const Eigen::VectorXd residual = f - a * z;
    Eigen::VectorXd coarse = Eigen::VectorXd::Zero(level.size());
    for (int i = 0; i < level.size(); ++i)
      for (int p = level.part_first[i]; p < level.part_first[i + 1]; ++p) coarse[i] += residual[level.parts[p]];
    coarse = solve(l + 1, coarse);
    for (int i = 0; i < level.size(); ++i)
      for (int p = level.part_first[i]; p < level.part_first[i + 1]; ++p) z[level.parts[p]] += coarse[i];
    return z + relax.cwiseProduct(f - a * z);
  }
  std::vector<int> order_;
  Hierarchy hierarchy_;
  std::vector<Eigen::MatrixXd> systems_;
};

TEST_P(SolverTest, TheErrorFallsAsTheoryPredicts) {
  for (const bool half : {false, true})
    for (Solver solver : {Solver::Verlet, Solver::Damped, Solver::Multigrid}) {
      TestScene scene = membrane(2, 1, half);
      // Translation of the whole mesh: the slowest mode if all vertices have the same springs.
      for (EnginePoint& point : scene.points) point.position_mm += Eigen::Vector3d(0.4, -0.2, 0.6);
      const SimplexMesh& mesh = scene.meshes[0].mesh;
      const int n = mesh.vertex_count();
      constexpr double kSpring = 5, kPoint = 0.5;
      std::vector<double> e(n);
      for (int i = 0; i < n; ++i) e[i] = !half || mesh.positions[i][2] > 1 ? kPoint : 0;
      // K is the stiffness matrix of the forces; z = B f.
      Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n, n);
      for (int i = 0; i < n; ++i) {
        k(i, i) += kSpring + e[i];
        for (int j : mesh.neighbours[i]) k(i, j) -= kSpring / 3;
      }
      Eigen::MatrixXd bk = k, first_bk = k;
      if (solver == Solver::Damped)
        for (int i = 0; i < n; ++i) bk.row(i) /= 2 * kSpring + e[i];
      if (solver == Solver::Multigrid) {
        // In the first step, the solver has not yet measured whether the mesh is constrained.
        std::vector<double> regularised = e;
        for (double& x : regularised) x += 10 * kSpring;
        const DenseCycle cycle(mesh, kSpring, e), first_cycle(mesh, kSpring, regularised);
        for (int i = 0; i < n; ++i) bk.col(i) = cycle(k.col(i)), first_bk.col(i) = first_cycle(k.col(i));
      }
      const Eigen::VectorXcd spectrum = Eigen::EigenSolver<Eigen::MatrixXd>(bk, false).eigenvalues();
      const double smallest = spectrum.real().minCoeff();
      EXPECT_LT(spectrum.imag().cwiseAbs().maxCoeff(), 1e-6);  // both factors are symmetric

      scene.simulation = by(solver);
      const Positions end = run(scene, 4000);
      const auto engine = make_engine();
      load(*engine, scene);
      Eigen::MatrixXd error(n, 3), before;
      for (int i = 0; i < n; ++i) error.row(i) = (mesh.positions[i] - end[i]).cast<double>();
      before = error;
      const double first = error.norm();
      SolverControl control;
      SolverState state;
      int steps = 0;
      double now = first;
      for (; steps < 4000 && now > 1e-5 * first; ++steps) {
        control.start(scene.simulation, stiffness_of(scene.meshes[0].forces, {}), state);
        const StepCoefficients c = control.coefficients();
        const Eigen::MatrixXd next = error + c.momentum * (error - before) -
                                     c.gain * ((steps == 0 && solver == Solver::Multigrid ? first_bk : bk) * error);
        before = error, error = next;
        state = engine->step(1).solver.at(0);
        const Positions p = positions_of(*engine, scene);
        double sum = 0;
        for (int i = 0; i < n; ++i) sum += (p[i] - end[i]).cast<double>().squaredNorm();
        now = std::sqrt(sum);
      }
      const double rate = std::log(now / first) / std::log(error.norm() / first);
      EXPECT_NEAR(rate, 1, 0.03) << static_cast<int>(solver) << (half ? " half" : " all") << " constrained, " << steps
                                 << " steps";
      // The estimated smallest eigenvalue agrees with the spectrum.
      if (solver != Solver::Verlet) {
        EXPECT_NEAR(state.min_eigenvalue, smallest, 0.2 * smallest) << static_cast<int>(solver) << half;
      }
    }
}

TEST_P(SolverTest, EstimatesDoNotDependOnTheBatchSize) {
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

TEST_P(SolverTest, AMeshWithoutTheCycleIsIndependentOfOneWithIt) {
  TestScene alone = busy_scene(3), with_cycle = membrane(3, 2);
  alone.points.clear();
  for (const ForceInfo& force : force_list())
    weight_of(alone.meshes[0].forces, force.id) =
        force.id == ForceId::Gradient || force.id == ForceId::Evidence ? 0.3f : 0.0f;
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
  const StepOutcome a = outcome_of(alone, {14}), b = outcome_of(both, {14}), c = outcome_of(both, {3, 9, 2}),
                    d = outcome_of(with_cycle, {14});
  EXPECT_GT(a.residual_mm.at(0), 1e-4);
  EXPECT_GT(a.solver.at(0).min_eigenvalue, 0);
  EXPECT_NEAR(b.residual_mm.at(1), a.residual_mm.at(0), 1e-3 * a.residual_mm.at(0));
  EXPECT_NEAR(b.solver.at(1).min_eigenvalue, a.solver.at(0).min_eigenvalue, 1e-3 * a.solver.at(0).min_eigenvalue);
  EXPECT_EQ(c.residual_mm.at(1), b.residual_mm.at(1));
  EXPECT_EQ(c.solver.at(1).min_eigenvalue, b.solver.at(1).min_eigenvalue);
  EXPECT_NEAR(b.residual_mm.at(0), d.residual_mm.at(0), 1e-3 * d.residual_mm.at(0));
}

TEST_P(SolverTest, AutomaticUsesCyclesOnlyForConstrainedMeshes) {
  TestScene scene = membrane(4, 2);
  scene.simulation = by(Solver::Automatic);
  TestScene weakly_constrained = scene;
  weakly_constrained.points.resize(1);
  const auto engine = make_engine();
  load(*engine, scene);
  EXPECT_TRUE(engine->step(1).solver.at(0).multigrid);
  load(*engine, weakly_constrained);
  EXPECT_FALSE(engine->step(1).solver.at(0).multigrid);
  // More points cause a new measurement; a move of the point does not.
  weakly_constrained.points[0].position_mm += Eigen::Vector3d(0, 0, 1);
  engine->set_points(weakly_constrained.points);
  EXPECT_FALSE(engine->step(1).solver.at(0).multigrid);
  engine->set_points(scene.points);
  EXPECT_TRUE(engine->step(1).solver.at(0).multigrid);
  engine->set_points({});
  EXPECT_FALSE(engine->step(1).solver.at(0).multigrid);
}

TEST_P(SolverTest, EachMeshUsesCyclesIndependently) {
  // The second mesh detects its slow modes later than the first one. Its steps must be those of a scene without the
  // first.
  TestScene first = membrane(3, 1), second = busy_scene(3);
  second.points.clear();
  for (const ForceInfo& force : force_list())
    weight_of(second.meshes[0].forces, force.id) = force.id == ForceId::Smoothing  ? 1.0f
                                                   : force.id == ForceId::Gradient ? 0.3f
                                                                                   : 0.0f;
  first.volume = second.volume;
  TestScene both = first;
  both.meshes.push_back(second.meshes[0]);
  for (TestScene* scene : {&second, &both}) scene->simulation = by(Solver::Automatic);
  const auto a = make_engine(), b = make_engine();
  load(*a, second), load(*b, both);
  bool multigrid = false;
  for (int k = 0; k < 40 && !multigrid; ++k) multigrid = a->step(10).solver.at(0).multigrid, b->step(10);
  ASSERT_TRUE(multigrid);
  const StepOutcome alone = a->step(50), beside = b->step(50);
  EXPECT_TRUE(beside.solver.at(1).multigrid);
  EXPECT_LT(beside.residual_mm.at(1), 3 * alone.residual_mm.at(0));
  EXPECT_LT(largest_distance(positions_of(*b, both, 1), positions_of(*a, second)), 0.02);
}

TEST_P(SolverTest, OnlyVerletDependsOnItsOwnParameters) {
  for (const char* name : {"timestep", "damping", "limit_timestep"})
    for (Solver solver : kSolvers) {
      const int index = find_parameter(simulation_table(), name);
      TestScene scene = busy_scene(2), other = scene;
      for (TestScene* s : {&scene, &other}) {
        weight_of(s->meshes[0].forces, ForceId::Smoothing) = 0.5f;
        s->simulation = by(solver);
        s->simulation.timestep = 2.5f;  // beyond the limit
      }
      float& value = value_of(other.simulation, index);
      value = value == 1 ? 0 : 0.3f;
      EXPECT_NE(same_bits(run(scene, 3), run(other, 3)), has_effect(scene.simulation, index))
          << name << static_cast<int>(solver);
    }
}

TEST_P(SolverTest, SolverStatesArePreservedByALoad) {
  TestScene scene = membrane(4, 2);
  scene.simulation = by(Solver::Damped);
  const auto engine = make_engine();
  load(*engine, scene);
  const SolverState estimate = engine->step(100).solver.at(0);
  EXPECT_GT(estimate.min_eigenvalue, 0);
  EngineMesh m;
  const TestMesh& t = scene.meshes[0];
  m.positions = m.previous = t.mesh.positions, m.neighbours = t.mesh.neighbours, m.parameters = t.forces,
  m.solver = estimate;
  engine->load(std::span(&m, 1), scene.simulation);
  EXPECT_EQ(engine->step(1).solver.at(0).min_eigenvalue, estimate.min_eigenvalue);
  // New weights reset the estimate.
  const std::vector<ForceParameters> same{t.forces};
  engine->set_parameters(same, scene.simulation);
  EXPECT_NE(engine->step(1).solver.at(0).min_eigenvalue, estimate.min_eigenvalue);
}

TEST_P(SolverTest, EstimatesAreUpdatedWheneverAPointMoves) {
  // The move shifts the refreshes. Even then, not every measurement of the solver may coincide with a refresh.
  for (int refresh : {2, 3, 5, 10})
    for (int at = 1; at < 10; ++at) {
      TestScene scene = membrane(2, 2);
      scene.simulation = by(Solver::Damped);
      scene.simulation.refresh_interval = static_cast<float>(refresh);
      const auto engine = make_engine();
      load(*engine, scene);
      const float guess = engine->step(at).solver.at(0).min_eigenvalue;
      scene.points[0].position_mm[0] += 0.1;
      engine->set_points(scene.points);
      EXPECT_NE(engine->step(60).solver.at(0).min_eigenvalue, guess)
          << "every " << refresh << " steps from step " << at;
    }
}

TEST_P(SolverTest, EveryForceAndAllTogetherStayBoundedWithEverySolver) {
  for (Solver solver : kSolvers) {
    TestScene scene = busy_scene(3, 10);
    for (const ForceInfo& force : force_list())
      weight_of(scene.meshes[0].forces, force.id) = force.parameters[0].maximum;
    scene.simulation = by(solver);
    scene.simulation.refresh_interval = 3;
    const Positions end = run(scene, 300);
    double farthest = 0;
    for (const Eigen::Vector3f& p : end) farthest = std::max(farthest, static_cast<double>(p.norm()));
    EXPECT_LT(farthest, 60) << static_cast<int>(solver);
  }
}

TEST_P(SolverTest, FoldedAndInvertedMeshesAreDetected) {
  // Sound, folded and inverted spheres are distinguished.
  TestScene scene = busy_scene(3);
  scene.simulation = simulation(1, 1);
  const auto engine = make_engine();
  load(*engine, scene);
  StepOutcome outcome = engine->step(1);
  EXPECT_EQ(outcome.folded_vertices.at(0), 0);
  EXPECT_FALSE(outcome.inverted.at(0));
  for (Eigen::Vector3f& p : scene.meshes[0].mesh.positions) p[0] = -p[0];
  load(*engine, scene);
  outcome = engine->step(1);
  EXPECT_TRUE(outcome.inverted.at(0));
  scene = busy_scene(3);
  scene.meshes[0].mesh.positions[5] *= 0.5f;
  load(*engine, scene);
  EXPECT_GT(engine->step(1).folded_vertices.at(0), 0);
}

}  // namespace
}  // namespace simplexseg
