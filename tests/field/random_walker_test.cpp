// SPDX-License-Identifier: Apache-2.0
// The solver of the random walker against factorisations.
#include "field/parallel/cpu_executor.h"
#include "field/parallel/walker.h"

#include <gtest/gtest.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <cmath>
#include <random>
#include <vector>

#include "references.h"

namespace simplexseg {
namespace {

using Walker = ParallelWalker<CpuFieldExecutor>;

struct Problem {
  BoxGrid grid;
  std::array<double, 3> spacing_mm;
  std::array<std::vector<float>, 3> conductance;
  std::vector<float> prior_weight, start;
  std::vector<std::uint8_t> target, fixed;
};

bool has_next(const BoxGrid& grid, int v, int axis) {
  const int at[3]{v % grid.row(), v / grid.row() % grid.size[1], v / grid.plane()};
  return at[axis] + 1 < grid.size[axis];
}

/// Conductances over four decades, one voxel in fifteen with a Dirichlet condition.
Problem random_problem(std::array<int, 3> size, std::array<double, 3> spacing_mm, float prior_weight) {
  Problem p{{size}, spacing_mm, {}, {}, {}, {}, {}};
  std::mt19937 random(7);
  const auto uniform = [&] { return static_cast<float>(random()) / 4294967296.0f; };
  const int n = p.grid.count();
  for (auto& w : p.conductance)
    for (int v = 0; v < n; ++v) w.push_back(std::pow(10.0f, -4 * uniform()));
  for (int v = 0; v < n; ++v) {
    p.prior_weight.push_back(prior_weight * uniform());
    p.target.push_back(static_cast<std::uint8_t>(random() % 256));
    p.fixed.push_back(random() % 15 == 0);
    p.start.push_back(p.fixed.back() ? static_cast<float>(random() % 2) : 0.5f);
  }
  p.fixed[0] = p.fixed[n - 1] = 1;
  p.start[0] = 0;
  p.start[n - 1] = 1;
  return p;
}

/// Solution with a tolerance. `rough`: larger tolerance of a first solution, from which the solver resumes.
std::vector<float> solve(const Problem& p, double tolerance, const RunJobs& run = run_serially(),
                         Walker::Report* report = nullptr, double rough = 0) {
  const CpuFieldExecutor executor(run);
  Walker walker(p.grid, p.spacing_mm, executor);
  for (int a = 0; a < 3; ++a)
    for (int v = 0; v < p.grid.count(); ++v)
      walker.conductances(a)[v] = has_next(p.grid, v, a) ? p.conductance[a][v] : 0.0f;
  executor.upload<float>(p.prior_weight, walker.prior_weight());
  executor.upload<float>(p.start, walker.field());
  int iterations = 0;
  walker.solve(p.target.data(), p.fixed.data(), rough > 0 ? rough : tolerance, 200);
  if (rough > 0) {
    iterations = walker.report().iterations;
    walker.resume(tolerance, 200);
  }
  Walker::Report done = walker.report();
  done.iterations += iterations;
  if (report) *report = done;
  return {walker.field(), walker.field() + p.grid.count()};
}

/// visit(row, column, value) for all terms of the linear system, visit(row, -1, value) for its right-hand side.
template <class Visit>
void each_term(const Problem& p, const Visit& visit) {
  for (int v = 0; v < p.grid.count(); ++v) {
    if (p.fixed[v]) {
      visit(v, v, 1.0);
      visit(v, -1, p.start[v]);
      continue;
    }
    visit(v, v, p.prior_weight[v]);
    visit(v, -1, p.prior_weight[v] * p.target[v] / 255.0);
  }
  for (int axis = 0; axis < 3; ++axis)
    for (int v = 0; v < p.grid.count(); ++v) {
      if (!has_next(p.grid, v, axis)) continue;
      const int u = v + p.grid.stride(axis);
      for (const auto& [from, to] : {std::pair{v, u}, std::pair{u, v}}) {
        if (p.fixed[from]) continue;
        visit(from, from, p.conductance[axis][v]);
        if (p.fixed[to])
          visit(from, -1, p.conductance[axis][v] * p.start[to]);
        else
          visit(from, to, -p.conductance[axis][v]);
      }
    }
}

Eigen::VectorXd dense_solution(const Problem& p) {
  const int n = p.grid.count();
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  each_term(p, [&](int row, int column, double x) { (column < 0 ? b[row] : a(row, column)) += x; });
  return a.partialPivLu().solve(b);
}
/// For problems that are too large for a dense matrix.
Eigen::VectorXd sparse_solution(const Problem& p) {
  const int n = p.grid.count();
  std::vector<Eigen::Triplet<double>> terms;
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  each_term(p, [&](int row, int column, double x) {
    if (column < 0)
      b[row] += x;
    else
      terms.emplace_back(row, column, x);
  });
  Eigen::SparseMatrix<double> a(n, n);
  a.setFromTriplets(terms.begin(), terms.end());
  Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper> solver(a);
  solver.setTolerance(1e-9);
  solver.setMaxIterations(5000);
  Eigen::VectorXd x = solver.solve(b);
  EXPECT_EQ(solver.info(), Eigen::Success);
  return x;
}

class Solver : public ::testing::TestWithParam<std::pair<std::array<int, 3>, std::array<double, 3>>> {};

TEST_P(Solver, AgreesWithADenseFactorisation) {
  for (const float prior_weight : {0.0f, 0.05f}) {
    const Problem p = random_problem(GetParam().first, GetParam().second, prior_weight);
    Walker::Report report;
    const std::vector<float> x = solve(p, 1e-6, run_serially(), &report);
    const Eigen::VectorXd reference = dense_solution(p);
    for (int v = 0; v < p.grid.count(); ++v) ASSERT_NEAR(x[v], reference[v], 2e-4) << v << " pull " << prior_weight;
    EXPECT_LT(report.iterations, 60);
    EXPECT_LE(report.error, 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Boxes, Solver,
                         ::testing::Values(std::pair{std::array{9, 8, 7}, std::array{1.0, 1.0, 1.0}},
                                           std::pair{std::array{12, 11, 4}, std::array{1.0, 1.0, 7.0}},
                                           std::pair{std::array{1, 13, 16}, std::array{2.0, 1.0, 1.0}},
                                           std::pair{std::array{17, 16, 2}, std::array{1.0, 1.0, 1.0}},
                                           std::pair{std::array{5, 1, 1}, std::array{1.0, 1.0, 1.0}}));

/// With several levels that all threads process.
TEST(RandomWalker, AgreesWithAnotherSolverOnALargeBox) {
  for (const std::array<double, 3>& spacing : {std::array{1.0, 1.0, 1.0}, std::array{1.0, 1.0, 3.0}}) {
    const Problem p = random_problem({51, 42, 33}, spacing, 0.005f);
    Walker::Report report;
    const std::vector<float> x = solve(p, 1e-5, run_serially(), &report);
    const Eigen::VectorXd reference = sparse_solution(p);
    for (int v = 0; v < p.grid.count(); ++v) ASSERT_NEAR(x[v], reference[v], 1e-3) << v;
    EXPECT_LT(report.iterations, 40);
    EXPECT_LE(report.error, 1e-5);
  }
}

/// Equal conductances and two voxels with a Dirichlet condition. Without coarse levels it would be 18 and 49.
TEST(RandomWalker, ALargeBoxTakesFewMoreIterationsThanASmallOne) {
  const auto iterations = [](const std::array<int, 3>& size) {
    Problem p = random_problem(size, {1, 1, 1}, 0);
    for (std::vector<float>& conductances : p.conductance) std::fill(conductances.begin(), conductances.end(), 1.0f);
    std::fill(p.fixed.begin() + 1, p.fixed.end() - 1, std::uint8_t{0});
    std::fill(p.start.begin() + 1, p.start.end() - 1, 0.5f);
    Walker::Report report;
    solve(p, 1e-4, run_serially(), &report);
    EXPECT_LE(report.error, 1e-4);
    return report.iterations;
  };
  const int few = iterations({16, 16, 16}), many = iterations({64, 64, 64});
  EXPECT_LE(few, 8);
  EXPECT_LE(many, 2 * few);
  EXPECT_LE(many, 13);
}

TEST(RandomWalker, ResumingGivesTheSameSolution) {
  const Problem p = random_problem({40, 30, 20}, {1, 1, 1}, 0.005f);
  Walker::Report at_once, carried;
  const std::vector<float> x = solve(p, 1e-4, run_serially(), &at_once),
                           y = solve(p, 1e-4, run_serially(), &carried, 0.1);
  EXPECT_EQ(x, y);
  EXPECT_EQ(at_once.iterations, carried.iterations);
  EXPECT_NE(x, solve(p, 0.1));
}

TEST(RandomWalker, TheStatedErrorMatchesTheRemainingOne) {
  const Problem p = random_problem({10, 9, 8}, {1, 1, 1}, 0.01f);
  const Eigen::VectorXd reference = dense_solution(p);
  const std::vector<float> rough = solve(p, 0.02);
  double most = 0;
  for (int v = 0; v < p.grid.count(); ++v) most = std::max(most, std::abs(rough[v] - reference[v]));
  EXPECT_LT(most, 0.1);
}

TEST(RandomWalker, AnyOrderOfJobsGivesTheSameBits) {
  const Problem p = random_problem({70, 61, 33}, {1, 1, 3}, 0.005f);
  Walker::Report in_turn;
  const std::vector<float> x = solve(p, 1e-3, run_serially(), &in_turn);
  for (const JobOrder& order : job_orders()) {
    Walker::Report report;
    EXPECT_EQ(solve(p, 1e-3, order.run, &report), x) << order.name;
    EXPECT_EQ(report.iterations, in_turn.iterations) << order.name;
    EXPECT_EQ(report.error, in_turn.error) << order.name;
  }
}

TEST(RandomWalker, AWarmStartTakesFewerIterations) {
  Problem p = random_problem({40, 40, 40}, {1, 1, 1}, 0.005f);
  Walker::Report cold, warm;
  p.start = solve(p, 1e-4, run_serially(), &cold);
  solve(p, 1e-4, run_serially(), &warm);
  EXPECT_GT(cold.iterations, 3);
  EXPECT_LT(warm.iterations, cold.iterations / 2);
}

TEST(RandomWalker, ReportsItsProgress) {
  const Problem p = random_problem({40, 30, 20}, {1, 1, 1}, 0.005f);
  const CpuFieldExecutor executor;
  Walker walker(p.grid, p.spacing_mm, executor);
  for (int a = 0; a < 3; ++a)
    for (int v = 0; v < p.grid.count(); ++v)
      walker.conductances(a)[v] = has_next(p.grid, v, a) ? p.conductance[a][v] : 0.0f;
  executor.upload<float>(p.start, walker.field());
  std::vector<float> fractions;
  walker.solve(p.target.data(), p.fixed.data(), 1e-4, 200, [&](float fraction) { fractions.push_back(fraction); });
  EXPECT_EQ(fractions.size(), static_cast<std::size_t>(walker.report().iterations));
  EXPECT_EQ(fractions.front(), 0);
  EXPECT_LT(fractions.back(), 1);
  EXPECT_GT(fractions.back(), 0.5f);
}

/// exp(-beta d^2) (least spacing / spacing)^2, 0 beside cells that are not finite and at the sides of the box.
TEST(RandomWalker, ConductancesFollowTheImage) {
  const BoxGrid grid{{17, 6, 4}};
  const std::array<double, 3> spacing_mm{1, 2, 3};
  std::mt19937 random(2);
  std::vector<float> image(grid.count());
  for (float& x : image) x = static_cast<float>(random() % 1000) / 3000;
  std::vector<std::uint8_t> finite(grid.count(), 1);
  for (int v = 0; v < grid.count(); v += 11) finite[v] = 0;
  for (const bool all_finite : {false, true}) {
    const CpuFieldExecutor executor;
    Walker walker(grid, spacing_mm, executor);
    set_edges(executor, walker, spacing_mm, image.data(), all_finite ? nullptr : finite.data(), 50, 0.3);
    std::vector<double> prior_weight(grid.count());
    int cut = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (int v = 0; v < grid.count(); ++v) {
        const int u = v + grid.stride(axis);
        const bool conducts = has_next(grid, v, axis) && (all_finite || (finite[v] && finite[u]));
        const double d = conducts ? double{image[u]} - image[v] : 0;
        const double conductance =
            conducts ? (std::exp(-50 * d * d) + 1e-5) / (spacing_mm[axis] * spacing_mm[axis]) : 0;
        ASSERT_NEAR(walker.conductances(axis)[v], conductance, 1e-5) << axis << ' ' << v;
        cut += !conducts;
        prior_weight[v] += 0.3 / 6 * conductance;
        if (conducts) prior_weight[u] += 0.3 / 6 * conductance;
      }
    EXPECT_GT(cut, 10);
    for (int v = 0; v < grid.count(); ++v) ASSERT_NEAR(walker.prior_weight()[v], prior_weight[v], 1e-5) << v;
  }
}

}  // namespace
}  // namespace simplexseg
