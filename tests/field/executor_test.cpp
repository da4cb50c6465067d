// SPDX-License-Identifier: Apache-2.0
#include "field/parallel/executor.h"
#include "field/parallel/cpu_executor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <random>
#include <vector>

#include "references.h"

namespace simplexseg {
namespace {

std::vector<JobOrder> all_orders() {
  std::vector<JobOrder> orders = job_orders();
  orders.push_back({"in turn", run_serially()});
  return orders;
}

/// Grids with all lengths of rows, and with more rows and cells than one job has.
std::vector<BoxGrid> grids() {
  std::vector<BoxGrid> all;
  for (const int cells : {1, 2, 7, 8, 9, 15, 16, 17, 31, 32, 33, 65})
    for (const std::array<int, 2>& rows : {std::array{1, 1}, std::array{3, 2}, std::array{4, 5}, std::array{70, 61}})
      all.push_back({{cells, rows[0], rows[1]}});
  all.push_back({{20000, 1, 3}});
  return all;
}

constexpr int kWrong = 1000;  // added to the count of a cell that is visited with other indices than its own

/// Counts visits of cells.
struct Visit {
  BoxGrid grid;
  int* count;
  void operator()(const CellAt& at) const {
    const bool right = is_in(grid, at.i, at.j, at.k) && at.v == (at.k * grid.size[1] + at.j) * grid.size[0] + at.i &&
                       at.left == (at.i > 0) && at.right == (at.i + 1 < grid.size[0]);
    count[at.v] += right ? 1 : kWrong;
  }
  template <int kLanes>
  void run(const CellAt& at) const {
    const bool right = at.i + kLanes <= grid.size[0] && at.v == (at.k * grid.size[1] + at.j) * grid.size[0] + at.i;
    for (int l = 0; l < kLanes; ++l) count[at.v + l] += right ? 1 : kWrong;
  }
};
/// Counts visits of elements.
struct VisitElement {
  int* count;
  void operator()(int v) const { ++count[v]; }
  template <int kLanes>
  void run(int v) const {
    for (int l = 0; l < kLanes; ++l) ++count[v + l];
  }
};

/// Elements on both sides of the sizes of a vector and of a job.
std::vector<int> element_counts() {
  return {
      0, 1, 2, 15, 16, 17, 31, 32, 33, kIndicesPerJob - 1, kIndicesPerJob, kIndicesPerJob + 17, 3 * kIndicesPerJob + 5};
}

TEST(CpuFieldExecutor, EachCellIsVisitedOnce) {
  for (const JobOrder& order : all_orders()) {
    const CpuFieldExecutor executor(order.run);
    for (const BoxGrid& grid : grids()) {
      std::vector<int> cells(grid.count()), by_lanes(grid.count());
      const std::vector<int> once(grid.count(), 1);
      executor.each_cell(grid, Visit{grid, cells.data()});
      EXPECT_EQ(cells, once) << order.name << ' ' << grid.size[0] << " x " << grid.size[1];
      executor.each_cell_lanes(grid, Visit{grid, by_lanes.data()});
      int wrong = 0;  // the last cells of a row may be visited twice
      each_index(grid, [&](int i, int, int, int v) {
        wrong += !(by_lanes[v] == 1 || (by_lanes[v] == 2 && i + CpuFieldExecutor::kLanes >= grid.size[0]));
      });
      EXPECT_EQ(wrong, 0) << order.name << ' ' << grid.size[0] << " x " << grid.size[1];
    }
  }
}

TEST(CpuFieldExecutor, EachCellOfAColourIsVisitedOnce) {
  for (const JobOrder& order : all_orders()) {
    const CpuFieldExecutor executor(order.run);
    for (const BoxGrid& grid : grids())
      for (const int colour : {0, 1}) {
        std::vector<int> expected(grid.count()), by_all(grid.count()), by_one(grid.count());
        each_index(grid, [&](int i, int j, int k, int v) { expected[v] = (i + j + k) % 2 == colour; });
        executor.all([&](const auto& all) { each_coloured(all, grid, colour, Visit{grid, by_all.data()}); });
        EXPECT_EQ(by_all, expected) << order.name << ' ' << grid.size[0] << " x " << grid.size[1] << ' ' << colour;
        executor.all([&](const auto& all) {
          all.by_one_block([&](const auto& block) { each_coloured(block, grid, colour, Visit{grid, by_one.data()}); });
        });
        EXPECT_EQ(by_one, expected) << order.name << ' ' << grid.size[0] << " x " << grid.size[1] << ' ' << colour;
      }
  }
}

TEST(CpuFieldExecutor, EachElementIsVisitedOnce) {
  for (const JobOrder& order : all_orders()) {
    const CpuFieldExecutor executor(order.run);
    for (const int n : element_counts()) {
      std::vector<int> elements(n), by_lanes(n), by_all(n);
      executor.each(n, VisitElement{elements.data()});
      executor.each_lanes(n, VisitElement{by_lanes.data()});
      executor.all([&](const auto& all) { all.each(n, VisitElement{by_all.data()}); });
      const std::vector<int> once(n, 1);
      EXPECT_EQ(elements, once) << order.name << ' ' << n;
      EXPECT_EQ(by_lanes, once) << order.name << ' ' << n;
      EXPECT_EQ(by_all, once) << order.name << ' ' << n;
    }
  }
}

/// Cells of a row are visited in ascending order.
TEST(CpuFieldExecutor, ARowIsVisitedInAscendingOrder) {
  static_assert(CpuFieldExecutor::kCellsInOrder);
  const BoxGrid grid{{33, 70, 61}};
  for (const JobOrder& order : all_orders()) {
    std::vector<int> place(grid.count(), -1);
    CpuFieldExecutor(order.run).each_cell(
        grid, [to = place.data()](const CellAt& at) { to[at.v] = at.i == 0 ? 0 : to[at.v - 1] + 1; });
    each_index(grid, [&](int i, int, int, int v) { ASSERT_EQ(place[v], i) << order.name; });
  }
}

struct CountTeam {
  static constexpr int kScratch = 100;
  int* count;
  template <class Block>
  void operator()(const Block& block, int t) const {
    std::fill_n(block.scratch, kScratch, static_cast<float>(t));
    block.sync();
    if (block.any(true) && !block.any(false) && std::count(block.scratch, block.scratch + kScratch, t) == kScratch)
      ++count[t];
  }
};
TEST(CpuFieldExecutor, EachTeamRunsOnceWithItsOwnMemory) {
  for (const JobOrder& order : all_orders())
    for (const int teams : {0, 1, 3, 4, 5, 1001}) {
      std::vector<int> count(teams);
      CpuFieldExecutor(order.run).blocks(teams, CountTeam{count.data()});
      EXPECT_EQ(count, std::vector<int>(teams, 1)) << order.name;
    }
}

std::vector<float> random_values(int n) {
  std::mt19937 random(11);
  std::vector<float> values(n);
  for (float& x : values) x = static_cast<float>(random()) / 4294967296.0f;
  return values;
}

struct Sums {
  Totals totals, of_rows;
  std::array<double, 2> sums;
  std::vector<int> histogram;
};
Sums sums_of(const std::vector<float>& values, const BoxGrid& grid, const RunJobs& run) {
  const CpuFieldExecutor executor(run);
  const int n = grid.count();
  Sums sums{{}, {}, {}, std::vector<int>(kBins, 3)};
  const float* const x = values.data();
  executor.all([&](const auto& all) {
    sums.totals = all.totals(n, [x](int v) { return Contribution{x[v], 1 - x[v]}; });
    sums.of_rows = all.totals_of_rows(grid, [x, &grid](int j, int k) {
      Totals row;
      for (int i = 0; i < grid.size[0]; ++i) {
        const float value = x[(k * grid.size[1] + j) * grid.size[0] + i];
        row.sum += value;
        row.largest = std::max(row.largest, value);
      }
      return row;
    });
  });
  executor.sums_into(
      n,
      [x](int v) {
        return Summands<2>{{x[v], x[v] * x[v]}};
      },
      sums.sums.data());
  executor.histogram(
      n, [x](int v) { return static_cast<int>(x[v] * (kBins + 200)) - 100; }, sums.histogram.data());
  return sums;
}

/// The reference adds in double, one element after the other.
TEST(CpuFieldExecutor, SumsDoNotDependOnTheOrderOfJobs) {
  for (const BoxGrid& grid : grids()) {
    const int n = grid.count();
    const std::vector<float> values = random_values(n);
    double sum = 0, squares = 0;
    float largest = 0, largest_rest = 0;
    std::vector<int> histogram(kBins, 3);
    for (const float x : values) {
      sum += x, squares += double{x} * x;
      largest = std::max(largest, x), largest_rest = std::max(largest_rest, 1 - x);
      const int bin = static_cast<int>(x * (kBins + 200)) - 100;
      if (bin >= 0 && bin < kBins) ++histogram[bin];
    }
    const Sums in_turn = sums_of(values, grid, run_serially());
    EXPECT_NEAR(in_turn.totals.sum, sum, 1e-6 * sum);
    EXPECT_EQ(in_turn.totals.largest, largest_rest);
    EXPECT_NEAR(in_turn.of_rows.sum, sum, 1e-12 * sum);
    EXPECT_EQ(in_turn.of_rows.largest, largest);
    EXPECT_NEAR(in_turn.sums[0], sum, 1e-12 * sum);
    EXPECT_NEAR(in_turn.sums[1], squares, 1e-7 * squares);
    EXPECT_EQ(in_turn.histogram, histogram);
    for (const JobOrder& order : job_orders()) {
      const Sums other = sums_of(values, grid, order.run);
      EXPECT_EQ(other.totals.sum, in_turn.totals.sum) << order.name;
      EXPECT_EQ(other.totals.largest, in_turn.totals.largest) << order.name;
      EXPECT_EQ(other.of_rows.sum, in_turn.of_rows.sum) << order.name;
      EXPECT_EQ(other.of_rows.largest, in_turn.of_rows.largest) << order.name;
      EXPECT_EQ(other.sums, in_turn.sums) << order.name;
      EXPECT_EQ(other.histogram, in_turn.histogram) << order.name;
    }
  }
}

TEST(CpuFieldExecutor, SumsOfNothingAreZero) {
  const Sums sums = sums_of({}, {{0, 0, 0}}, run_serially());
  EXPECT_EQ(sums.totals.sum, 0);
  EXPECT_EQ(sums.of_rows.sum, 0);
  EXPECT_EQ(sums.sums, (std::array{0.0, 0.0}));
}

TEST(CpuFieldExecutor, ArraysHoldWhatIsCopiedToThem) {
  const CpuFieldExecutor executor;
  std::vector<int> values(1000), back(1000);
  std::iota(values.begin(), values.end(), -3);
  auto array = executor.copy_of(std::span<const int>(values));
  EXPECT_EQ(array.size(), 1000u);
  EXPECT_EQ(array.bytes(), 4000u);
  executor.download<int>(array.data(), back);
  EXPECT_EQ(back, values);
  const auto other = executor.array<int>(1000);
  executor.copy<int>(array.data(), other.data(), 1000);
  executor.clear(array.data(), 10);
  EXPECT_EQ(array.data()[9], 0);
  EXPECT_EQ(array.data()[10], 7);
  const auto fetched = executor.fetch<int>(other.data(), 1000);
  executor.clear(other.data(), 1000);
  executor.receive<int>(fetched, back);
  EXPECT_EQ(back, values);
  auto moved = std::move(array);
  EXPECT_EQ(moved.data()[10], 7);
  EXPECT_EQ(array.size(), 0u);  // NOLINT(bugprone-use-after-move): a moved array is empty
  array = std::move(moved);
  EXPECT_EQ(array.data()[10], 7);
}

TEST(CpuFieldExecutor, PaddedArraysAreZeroAndHaveAPlaneOnEitherSide) {
  const CpuFieldExecutor executor;
  const BoxGrid grid{{5, 4, 3}};
  const auto array = executor.padded<float>(grid);
  EXPECT_EQ(array.size(), 60u);
  EXPECT_EQ(array.bytes(), (60u + 2 * 20u) * sizeof(float));
  for (int v = -20; v < 80; ++v) ASSERT_EQ(array.data()[v], 0) << v;
}

TEST(CpuFieldExecutor, ReportsTheProgressOfAnIteration) {
  const CpuFieldExecutor executor;
  std::vector<float> fractions;
  executor.all(
      [](const auto& all) {
        for (const float error : {1.0f, 0.1f, 0.01f}) all.report(1, error, 0.01);
        EXPECT_TRUE(all.is_first());
      },
      [&](float fraction) { fractions.push_back(fraction); });
  ASSERT_EQ(fractions.size(), 3u);
  EXPECT_NEAR(fractions[0], 0, 1e-6);
  EXPECT_NEAR(fractions[1], 0.5, 1e-6);
  EXPECT_NEAR(fractions[2], 1, 1e-6);
}

}  // namespace
}  // namespace simplexseg
