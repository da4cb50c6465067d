// SPDX-License-Identifier: Apache-2.0
#include "evidence/connected.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace simplexseg {
namespace {

/// Reference flood fill, voxel by voxel.
std::vector<std::uint8_t> flooded(const std::vector<std::uint8_t>& set, const std::vector<std::uint8_t>& start,
                                  const std::array<int, 3>& size) {
  std::vector<std::uint8_t> reached(set.size());
  for (std::size_t v = 0; v < set.size(); ++v) reached[v] = set[v] && start[v];
  for (bool changed = true; changed;) {
    changed = false;
    for (int k = 0, v = 0; k < size[2]; ++k)
      for (int j = 0; j < size[1]; ++j)
        for (int i = 0; i < size[0]; ++i, ++v) {
          if (!set[v] || reached[v]) continue;
          const int row = size[0], plane = size[0] * size[1];
          const bool beside = (i > 0 && reached[v - 1]) || (i < size[0] - 1 && reached[v + 1]) ||
                              (j > 0 && reached[v - row]) || (j < size[1] - 1 && reached[v + row]) ||
                              (k > 0 && reached[v - plane]) || (k < size[2] - 1 && reached[v + plane]);
          if (beside) reached[v] = 1, changed = true;
        }
  }
  return reached;
}

TEST(Connected, AgreesWithAFloodFill) {
  std::mt19937 random(3);
  for (const std::array<int, 3> size : {std::array{17, 13, 11}, std::array{9, 1, 8}, std::array{1, 7, 1}}) {
    for (const double share : {0.2, 0.33, 0.5, 1.0}) {
      std::bernoulli_distribution in(share), begins(0.02);
      std::vector<std::uint8_t> set(size[0] * size[1] * size[2]), start(set.size());
      for (std::uint8_t& s : set) s = in(random);
      for (std::uint8_t& s : start) s = begins(random);
      start[set.size() / 2] = 1;
      const std::vector<std::uint8_t> expected = flooded(set, start, size);
      keep_connected(set, start, size);
      EXPECT_EQ(set, expected) << "share " << share;
    }
  }
}

TEST(Connected, WithoutAStartNothingIsKept) {
  std::vector<std::uint8_t> set(27, 1);
  keep_connected(set, std::vector<std::uint8_t>(27), {3, 3, 3});
  EXPECT_EQ(set, std::vector<std::uint8_t>(27));
}

}  // namespace
}  // namespace simplexseg
