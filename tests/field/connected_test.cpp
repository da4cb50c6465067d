// SPDX-License-Identifier: Apache-2.0
#include "field/parallel/connected.h"
#include "field/parallel/cpu_executor.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "references.h"

namespace simplexseg {
namespace {

std::vector<std::uint8_t> kept(const std::vector<std::uint8_t>& set, const std::vector<std::uint8_t>& start,
                               const BoxGrid& grid, const RunJobs& run = run_serially()) {
  const CpuFieldExecutor executor(run);
  std::vector<int> parent(set.size(), 7);
  std::vector<std::uint8_t> keep(set.size(), 7), result(set.size());
  const KeptVoxels voxels = keep_connected(
      executor, grid, [&](const CellAt& at) { return set[at.v] != 0; },
      [&](const CellAt& at) { return start[at.v] != 0; }, parent.data(), keep.data());
  for (int v = 0; v < grid.count(); ++v) result[v] = voxels(v);
  return result;
}

TEST(Connected, EqualsAFloodFill) {
  std::mt19937 random(3);
  for (const std::array<int, 3>& size : {std::array{17, 13, 11}, std::array{9, 1, 8}, std::array{1, 7, 1},
                                         std::array{1, 40, 33}, std::array{60, 50, 40}}) {
    for (const double share : {0.2, 0.33, 0.5, 1.0}) {
      const BoxGrid grid{size};
      std::bernoulli_distribution in(share), begins(0.002);
      std::vector<std::uint8_t> set(grid.count()), start(grid.count());
      for (std::uint8_t& s : set) s = in(random);
      for (std::uint8_t& s : start) s = begins(random);
      start[grid.count() / 2] = set[grid.count() / 2] = 1;
      const std::vector<std::uint8_t> expected = flooded(set, start, grid);
      EXPECT_EQ(kept(set, start, grid), expected) << "share " << share;
      for (const JobOrder& order : job_orders())
        EXPECT_EQ(kept(set, start, grid, order.run), expected) << "share " << share << ", " << order.name;
    }
  }
}

TEST(Connected, WithoutAStartNothingIsKept) {
  const std::vector<std::uint8_t> set(27, 1), none(27);
  EXPECT_EQ(kept(set, none, {{3, 3, 3}}), none);
  EXPECT_EQ(kept(none, set, {{3, 3, 3}}), none);
}

}  // namespace
}  // namespace simplexseg
