// SPDX-License-Identifier: Apache-2.0
// Components, limited distances and Gaussians of voxels against plain references, bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "image/distance_map.h"
#include "image/gaussian.h"
#include "image/label_surface.h"

namespace simplexseg {
namespace {

Mask random_mask(const std::array<int, 3>& size, double share, unsigned seed) {
  Mask mask;
  mask.geometry.size = size;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (std::size_t v = 0; v < mask.geometry.voxel_count(); ++v) mask.voxels.push_back(uniform(random) < share);
  return mask;
}

/// Components by a search from voxel to voxel; the voxels of each in ascending order.
std::vector<std::vector<std::size_t>> searched_components(const Mask& mask) {
  const VoxelBox box{{0, 0, 0}, mask.geometry.size};
  std::vector<std::uint8_t> remaining = mask.voxels;
  std::vector<std::vector<std::size_t>> parts;
  for (std::size_t start = 0; start < remaining.size(); ++start) {
    if (!remaining[start]) continue;
    std::vector<std::size_t>& part = parts.emplace_back(1, start);
    remaining[start] = 0;
    for (std::size_t n = 0; n < part.size(); ++n) {
      const int v = static_cast<int>(part[n]), ni = box.size[0], nj = box.size[1];
      const std::array<int, 3> at{v % ni, v / ni % nj, v / ni / nj};
      for (const int direction : {-1, 1})
        for (int axes = 1; axes < 8; ++axes) {
          std::array<int, 3> to = at;
          bool within = true;
          for (int a = 0; a < 3; ++a) {
            to[a] += (axes >> a & 1) * direction;
            within = within && to[a] >= 0 && to[a] < box.size[a];
          }
          const std::size_t next = within ? box.offset(to[0], to[1], to[2]) : 0;
          if (within && remaining[next]) remaining[next] = 0, part.push_back(next);
        }
    }
    std::sort(part.begin(), part.end());
  }
  std::stable_sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return parts;
}

TEST(VoxelFilters, ComponentsEqualThoseOfASearch) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const std::array<int, 3> size{1 + static_cast<int>(seed % 13), 1 + static_cast<int>(seed * 7 % 11),
                                  1 + static_cast<int>(seed * 3 % 9)};
    for (const double share : {0.05, 0.15, 0.3, 0.6, 1.0}) {
      const Mask mask = random_mask(size, share, seed);
      EXPECT_EQ(connected_components(mask), searched_components(mask)) << seed << ' ' << share;
    }
  }
}

TEST(VoxelFilters, DistancesUpToALimitHaveTheSameBits) {
  const VoxelBox box{{0, 0, 0}, {31, 26, 19}};
  for (const Eigen::Vector3d& spacing :
       {Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(0.7, 0.7, 0.8), Eigen::Vector3d(1, 2.5, 0.3)})
    for (const double share : {0.0003, 0.01, 0.3, 0.97}) {
      const std::vector<std::uint8_t> set = random_mask(box.size, share, 5).voxels;
      const Eigen::Matrix3d mm = spacing.asDiagonal();
      const std::vector<float> all = distance_map(set, box, mm);
      for (const double limit_mm : {0.1, 1.0, 1.4, 3.0, 8.0, 1e9}) {
        std::vector<float> expected = all;
        for (float& one : expected)
          if (one > limit_mm) one = INFINITY;
        EXPECT_EQ(distance_map(set, box, mm, limit_mm), expected)
            << spacing.transpose() << ' ' << share << ' ' << limit_mm;
      }
    }
}

TEST(VoxelFilters, TheGaussianOfOnesHasTheBitsOfTheFullBox) {
  for (const std::array<int, 3>& size : {std::array<int, 3>{1, 1, 1}, {2, 5, 9}, {30, 7, 13}, {12, 41, 8}})
    for (const std::array<double, 3>& deviation : {std::array<double, 3>{1, 1, 1}, {0.4, 2.2, 3.7}, {0, 1.3, 12}}) {
      const VoxelBox box{{0, 0, 0}, size};
      std::vector<float> full(box.voxel_count(), 1.0f);
      smooth_gaussian(full, box, deviation);
      const GaussianOfOnes small(box, deviation);
      for (int k = 0; k < size[2]; ++k)
        for (int j = 0; j < size[1]; ++j)
          for (int i = 0; i < size[0]; ++i)
            ASSERT_EQ(small(i, j, k), full[box.offset(i, j, k)]) << i << ' ' << j << ' ' << k;
    }
}

}  // namespace
}  // namespace simplexseg
