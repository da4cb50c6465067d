// SPDX-License-Identifier: Apache-2.0
// The solver against a dense factorisation, and the geodesic distance against Dijkstra.
#include "evidence/random_walker.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <queue>
#include <random>

#include "core/thread_pool.h"
#include "evidence/geodesic_distance.h"
#include "evidence/parallel/walker.h"

namespace simplexseg {
namespace {

struct Problem {
  BoxGrid grid;
  std::array<double, 3> spacing_mm;
  std::array<std::vector<float>, 3> weight;
  std::vector<float> pull, start;
  std::vector<std::uint8_t> target, held;
};

/// Conductances over four decades, one voxel in fifteen with a Dirichlet condition.
Problem random_problem(std::array<int, 3> size, std::array<double, 3> spacing_mm, float pull) {
  Problem p{{size}, spacing_mm, {}, {}, {}, {}, {}};
  std::mt19937 random(7);
  const auto uniform = [&] { return static_cast<float>(random()) / 4294967296.0f; };
  const int n = p.grid.count();
  for (auto& w : p.weight)
    for (int v = 0; v < n; ++v) w.push_back(std::pow(10.0f, -4 * uniform()));
  for (int v = 0; v < n; ++v) {
    p.pull.push_back(pull * uniform());
    p.target.push_back(static_cast<std::uint8_t>(random() % 256));
    p.held.push_back(random() % 15 == 0);
    p.start.push_back(p.held.back() ? static_cast<float>(random() % 2) : 0.5f);
  }
  p.held[0] = p.held[n - 1] = 1;
  p.start[0] = 0;
  p.start[n - 1] = 1;
  return p;
}

/// Solution with a tolerance. `rough`: larger tolerance of a first solution, from which the solver resumes.
std::vector<float> solve(const Problem& p, double tolerance, const RunJobs& run, RandomWalker::Report* report = nullptr,
                         double rough = 0) {
  RandomWalker walker(p.grid, p.spacing_mm, run);
  for (int a = 0; a < 3; ++a) std::copy(p.weight[a].begin(), p.weight[a].end(), walker.weights(a).begin());
  std::copy(p.pull.begin(), p.pull.end(), walker.pull().begin());
  std::copy(p.start.begin(), p.start.end(), walker.field().begin());
  RandomWalker::Report done = walker.solve(p.target, p.held, rough > 0 ? rough : tolerance, 200);
  if (rough > 0) {
    const int iterations = done.iterations;
    done = walker.resume(tolerance, 200);
    done.iterations += iterations;
  }
  if (report) *report = done;
  return {walker.field().begin(), walker.field().end()};
}

/// Solution by the parallel version on the serial executor.
std::vector<float> solve_in_parallel(const Problem& p, double tolerance, double rough = 0,
                                     ParallelWalker<SerialExecutor>::Report* report = nullptr) {
  const SerialExecutor executor;
  ParallelWalker<SerialExecutor> walker(p.grid, p.spacing_mm, executor);
  for (int a = 0; a < 3; ++a)
    for (int v = 0; v < p.grid.count(); ++v) {
      const int at[3]{v % p.grid.size[0], v / p.grid.size[0] % p.grid.size[1], v / p.grid.plane()};
      walker.weights(a)[v] = at[a] + 1 < p.grid.size[a] ? p.weight[a][v] : 0.0f;
    }
  executor.upload<float>(p.pull, walker.pull());
  executor.upload<float>(p.start, walker.field());
  int iterations = 0;
  walker.solve(p.target.data(), p.held.data(), rough > 0 ? rough : tolerance, 200);
  if (rough > 0) {
    iterations = walker.report().iterations;
    walker.resume(tolerance, 200);
  }
  ParallelWalker<SerialExecutor>::Report done = walker.report();
  done.iterations += iterations;
  if (report) *report = done;
  return {walker.field(), walker.field() + p.grid.count()};
}

Eigen::VectorXd dense_solution(const Problem& p) {
  const int n = p.grid.count();
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  for (int v = 0; v < n; ++v) {
    const int at[3]{v % p.grid.size[0], v / p.grid.size[0] % p.grid.size[1], v / p.grid.plane()};
    a(v, v) += p.pull[v];
    b[v] += p.pull[v] * p.target[v] / 255.0;
    for (int axis = 0; axis < 3; ++axis) {
      if (at[axis] + 1 == p.grid.size[axis]) continue;
      const int u = v + p.grid.stride(axis);
      const double w = p.weight[axis][v];
      a(v, v) += w;
      a(u, u) += w;
      a(v, u) -= w;
      a(u, v) -= w;
    }
  }
  for (int v = 0; v < n; ++v) {
    if (!p.held[v]) continue;
    a.row(v).setZero();
    a(v, v) = 1;
    b[v] = p.start[v];
  }
  return a.partialPivLu().solve(b);
}

class Solver : public ::testing::TestWithParam<std::pair<std::array<int, 3>, std::array<double, 3>>> {};

TEST_P(Solver, AgreesWithADenseFactorisation) {
  for (const float pull : {0.0f, 0.05f}) {
    const Problem p = random_problem(GetParam().first, GetParam().second, pull);
    RandomWalker::Report report;
    const std::vector<float> x = solve(p, 1e-6, run_in_turn(), &report);
    const Eigen::VectorXd reference = dense_solution(p);
    for (int v = 0; v < p.grid.count(); ++v) ASSERT_NEAR(x[v], reference[v], 2e-4) << v << " pull " << pull;
    EXPECT_LT(report.iterations, 60);
    EXPECT_LE(report.error, 1e-6);
  }
}

TEST_P(Solver, ParallelVersionAgreesWithADenseFactorisation) {
  for (const float pull : {0.0f, 0.05f}) {
    const Problem p = random_problem(GetParam().first, GetParam().second, pull);
    ParallelWalker<SerialExecutor>::Report report;
    const std::vector<float> x = solve_in_parallel(p, 1e-6, 0, &report);
    const Eigen::VectorXd reference = dense_solution(p);
    for (int v = 0; v < p.grid.count(); ++v) ASSERT_NEAR(x[v], reference[v], 2e-4) << v << " pull " << pull;
    EXPECT_LT(report.iterations, 60);
    EXPECT_LE(report.error, 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Boxes, Solver,
                         ::testing::Values(std::pair{std::array{9, 8, 7}, std::array{1.0, 1.0, 1.0}},
                                           std::pair{std::array{12, 11, 4}, std::array{1.0, 1.0, 7.0}},
                                           std::pair{std::array{1, 13, 16}, std::array{2.0, 1.0, 1.0}},
                                           std::pair{std::array{5, 1, 1}, std::array{1.0, 1.0, 1.0}}));

TEST(RandomWalker, ParallelVersionTakesTheSameIterations) {
  for (const std::array<double, 3>& spacing : {std::array{1.0, 1.0, 1.0}, std::array{1.0, 1.0, 3.0}}) {
    const Problem p = random_problem({70, 61, 33}, spacing, 0.005f);  // several levels larger than a block
    RandomWalker::Report report;
    ParallelWalker<SerialExecutor>::Report parallel;
    const std::vector<float> x = solve(p, 1e-3, run_in_turn(), &report), y = solve_in_parallel(p, 1e-3, 0, &parallel);
    EXPECT_EQ(parallel.iterations, report.iterations);
    EXPECT_NEAR(parallel.error, report.error, 1e-5);
    for (int v = 0; v < p.grid.count(); ++v) ASSERT_NEAR(y[v], x[v], 1e-4) << v;
  }
}

TEST(RandomWalker, ResumingGivesTheSameSolution) {
  const Problem p = random_problem({40, 30, 20}, {1, 1, 1}, 0.005f);
  RandomWalker::Report at_once, carried;
  const std::vector<float> x = solve(p, 1e-4, run_in_turn(), &at_once),
                           y = solve(p, 1e-4, run_in_turn(), &carried, 0.1);
  EXPECT_EQ(x, y);
  EXPECT_EQ(at_once.iterations, carried.iterations);
  EXPECT_NE(x, solve(p, 0.1, run_in_turn()));
}

TEST(RandomWalker, ParallelVersionResumesToTheSameSolution) {
  const Problem p = random_problem({40, 30, 20}, {1, 1, 1}, 0.005f);
  ParallelWalker<SerialExecutor>::Report at_once, carried;
  const std::vector<float> x = solve_in_parallel(p, 1e-4, 0, &at_once), y = solve_in_parallel(p, 1e-4, 0.1, &carried);
  EXPECT_EQ(x, y);
  EXPECT_EQ(at_once.iterations, carried.iterations);
  EXPECT_NE(x, solve_in_parallel(p, 0.1));
}

TEST(RandomWalker, TheStatedErrorMatchesTheRemainingOne) {
  const Problem p = random_problem({10, 9, 8}, {1, 1, 1}, 0.01f);
  const Eigen::VectorXd reference = dense_solution(p);
  const std::vector<float> rough = solve(p, 0.02, run_in_turn());
  double most = 0;
  for (int v = 0; v < p.grid.count(); ++v) most = std::max(most, std::abs(rough[v] - reference[v]));
  EXPECT_LT(most, 0.1);
}

TEST(RandomWalker, TwoThreadsGiveTheBitsOfOne) {
  const Problem p = random_problem({70, 61, 33}, {1, 1, 3}, 0.005f);
  ThreadPool pool(2);
  const RunJobs on_two = [&](int jobs, const std::function<void(int)>& job) { pool.run(jobs, job); };
  EXPECT_EQ(solve(p, 1e-3, run_in_turn()), solve(p, 1e-3, on_two));
}

TEST(RandomWalker, AWarmStartTakesFewerIterations) {
  Problem p = random_problem({40, 40, 40}, {1, 1, 1}, 0.005f);
  RandomWalker::Report cold, warm;
  p.start = solve(p, 1e-4, run_in_turn(), &cold);
  solve(p, 1e-4, run_in_turn(), &warm);
  EXPECT_GT(cold.iterations, 3);
  EXPECT_LT(warm.iterations, cold.iterations / 2);
}

void geodesic_distance_agrees_with_dijkstra(const EdgeCost& cost) {
  const BoxGrid grid{{9, 8, 6}};
  const std::array<double, 3> spacing{1, 1, 2.5};
  std::mt19937 random(3);
  std::vector<float> image(grid.count());
  for (float& x : image) x = static_cast<float>(random() % 1000) / 1000;
  std::vector<float> distance(grid.count(), 1e4f);
  const std::array<int, 2> sources{3, 200};
  for (const int s : sources) distance[s] = 0;
  lower_geodesic_distance(distance, image, grid, spacing, cost, 50);

  std::vector<double> exact(grid.count(), 1e9);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (const int s : sources) queue.push({exact[s] = 0, s});
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > exact[v]) continue;
    const int i = v % 9, j = v / 9 % 8, k = v / 72;
    for (int dk = -1; dk <= 1; ++dk)
      for (int dj = -1; dj <= 1; ++dj)
        for (int di = -1; di <= 1; ++di) {
          if (i + di < 0 || i + di > 8 || j + dj < 0 || j + dj > 7 || k + dk < 0 || k + dk > 5) continue;
          const int u = v + di + 9 * dj + 72 * dk;
          const double difference = std::abs(image[u] - image[v]), square = difference * difference;
          const double step = cost.edge > 0 ? square / (square + cost.edge * cost.edge) : difference;
          const double to = d + step + cost.length * std::sqrt(di * di + dj * dj + 6.25 * dk * dk);
          if (to < exact[u] - 1e-12) queue.push({exact[u] = to, u});
        }
  }
  for (int v = 0; v < grid.count(); ++v) EXPECT_NEAR(distance[v], exact[v], 1e-4) << v;
}
TEST(GeodesicDistance, AgreesWithDijkstra) { geodesic_distance_agrees_with_dijkstra({0.1f}); }
TEST(GeodesicDistance, AgreesWithDijkstraWhereEveryEdgeCountsOnce) {
  geodesic_distance_agrees_with_dijkstra({0.05f, 0.2f});
}

}  // namespace
}  // namespace simplexseg
