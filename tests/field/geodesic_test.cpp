// SPDX-License-Identifier: Apache-2.0
#include "field/parallel/geodesic.h"
#include "field/parallel/cpu_executor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "ellipsoid_scene.h"
#include "field/box_image.h"
#include "references.h"

namespace simplexseg {
namespace {

struct Problem {
  BoxGrid grid;
  std::array<double, 3> spacing_mm;
  std::vector<float> image;
};

Problem noise(const std::array<int, 3>& size, const std::array<double, 3>& spacing_mm) {
  Problem problem{{size}, spacing_mm, {}};
  std::mt19937 random(3);
  for (int v = 0; v < problem.grid.count(); ++v) problem.image.push_back(static_cast<float>(random() % 1000) / 1000);
  return problem;
}

/// Distances from the cells in `starts`, one list for each cost.
std::vector<std::vector<float>> distances(const Problem& problem, const std::vector<std::vector<int>>& starts,
                                          const std::vector<EdgeCost>& costs, const RunJobs& run = run_serially()) {
  const CpuFieldExecutor executor(run);
  ParallelGeodesic<CpuFieldExecutor> geodesic(executor, problem.grid, problem.spacing_mm, problem.image.data());
  std::vector<std::vector<float>> all(costs.size(), std::vector<float>(problem.image.size(), 1e4f));
  std::vector<ParallelGeodesic<CpuFieldExecutor>::Distance> several;
  for (std::size_t c = 0; c < costs.size(); ++c) {
    for (const int v : starts[c]) all[c][v] = 0;
    several.push_back({all[c].data(), costs[c]});
  }
  geodesic.begin(several);
  geodesic.finish();
  return all;
}

void expect_dijkstra(const Problem& problem, const std::vector<std::vector<int>>& starts,
                     const std::vector<EdgeCost>& costs) {
  const std::vector<std::vector<float>> found = distances(problem, starts, costs);
  for (std::size_t c = 0; c < costs.size(); ++c) {
    std::vector<std::uint8_t> start(problem.image.size());
    for (const int v : starts[c]) start[v] = 1;
    const std::vector<double> exact = dijkstra(start, problem.image, problem.grid, problem.spacing_mm, costs[c]);
    for (std::size_t v = 0; v < exact.size(); ++v)
      ASSERT_NEAR(found[c][v], exact[v], 1e-5 + 3e-5 * exact[v]) << "cost " << c << ", cell " << v;
  }
}

const EdgeCost kChanges{0.02f, 0}, kEdges{0.002f, 0.06f};

TEST(Geodesic, EqualsDijkstraInOneTile) {
  const Problem problem = noise({9, 8, 6}, {1, 1, 2.5});
  expect_dijkstra(problem, {{3, 200}, {3, 200}}, {{0.1f, 0}, {0.05f, 0.2f}});
}

TEST(Geodesic, EqualsDijkstraOverTilesOfAnySize) {
  for (const std::array<int, 3>& size : {std::array{16, 17, 33}, std::array{50, 1, 18}, std::array{1, 40, 20},
                                         std::array{35, 20, 1}, std::array{31, 32, 3}}) {
    const Problem problem = noise(size, {0.8, 1.1, 3});
    const int last = problem.grid.count() - 1;
    expect_dijkstra(problem, {{0}, {last}, {last / 2}, {0, last}, {last / 3}},
                    {kChanges, kEdges, {0, 0}, {0.3f, 0}, {0.05f, 0.4f}});
  }
}

TEST(Geodesic, EqualsDijkstraInAnImageWithAnObject) {
  const Scene scene = ellipsoid(36, 2, {13, 11, 9}, 25);
  const BoxImage image =
      extract_box(scene.image, kVoxelCells, {{0, 0, 0}, scene.image.geometry().size}, run_serially());
  const int middle = (9 * 36 + 18) * 36 + 18;
  expect_dijkstra({image.grid, {1, 1, 2}, image.value}, {{middle}, {middle}}, {kChanges, kEdges});
}

/// Corridors between walls with gaps at alternating ends, so that the path turns many times; the last one is closed.
Problem maze(float wall) {
  Problem maze{{{70, 70, 2}}, {1, 1, 1}, std::vector<float>(70 * 70 * 2)};
  each_index(maze.grid, [&](int i, int j, int, int v) {
    const bool gap = i == (j / 2 % 2 == 0 ? 69 : 0);
    if (j % 2 == 1 && (!gap || j == 61)) maze.image[v] = wall;
  });
  return maze;
}

TEST(Geodesic, FollowsAMaze) {
  const Problem problem = maze(1000);
  expect_dijkstra(problem, {{0}}, {{0.1f, 0}});
  const float found = distances(problem, {{0}}, {{0.1f, 0}}).front()[60 * 70];
  EXPECT_GT(found, 0.1f * 30 * 69);  // along each of 30 corridors
  EXPECT_LT(found, 1000);
}

TEST(Geodesic, DoesNotPassNaN) {
  const Problem problem = maze(std::numeric_limits<float>::quiet_NaN());
  expect_dijkstra(problem, {{0}}, {{0.1f, 0}});
  const std::vector<float> found = distances(problem, {{0}}, {{0.1f, 0}}).front();
  EXPECT_LT(found[60 * 70], 1e4f);
  EXPECT_EQ(found[62 * 70], 1e4f);
}

TEST(Geodesic, AnyOrderOfJobsGivesTheSameBits) {
  const Problem problem = noise({50, 41, 37}, {1, 1, 1.5});
  const std::vector<std::vector<int>> starts{{0}, {40000}, {7, 30000}};
  const std::vector<EdgeCost> costs{kChanges, kEdges, {0.1f, 0}};
  const std::vector<std::vector<float>> in_turn = distances(problem, starts, costs);
  for (const JobOrder& order : job_orders())
    EXPECT_EQ(distances(problem, starts, costs, order.run), in_turn) << order.name;
}

}  // namespace
}  // namespace simplexseg
