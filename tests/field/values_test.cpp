// SPDX-License-Identifier: Apache-2.0
// Distances and field values on the executor of the CPU, compared with distance_map() and field_values().
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "field/box_image.h"
#include "field/parallel/cpu_executor.h"
#include "field/parallel/distance.h"
#include "field/parallel/field_values.h"
#include "session/field_voxels.h"

namespace simplexseg {
namespace {

const CpuFieldExecutor executor;
const std::array<std::array<double, 3>, 3> kSpacings{{{1, 1, 1}, {0.7, 0.7, 3}, {2.5, 0.9, 1.1}}};

std::vector<float> noise_of(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0, 1);
  std::vector<float> values(count);
  for (float& x : values) x = noise(random);
  return values;
}

/// Random blobs.
std::vector<std::uint8_t> blobs(const BoxGrid& grid, float threshold, unsigned seed) {
  std::vector<float> values = noise_of(grid.count(), seed);
  smooth(values, grid, {2, 2, 2}, run_serially());
  std::vector<std::uint8_t> set(values.size());
  for (std::size_t v = 0; v < set.size(); ++v) set[v] = values[v] > threshold;
  return set;
}

TEST(SquaredDistance, EqualsTheDistanceMapUpToItsReach) {
  const BoxGrid grid{{25, 22, 14}};
  const std::vector<std::uint8_t> set = blobs(grid, 0.03f, 4);
  std::vector<std::uint8_t> others(set.size());
  std::ranges::transform(set, others.begin(), [](std::uint8_t is) { return !is; });
  for (const std::array<double, 3>& spacing : kSpacings) {
    const Eigen::Matrix3d mm = Eigen::Vector3d(spacing[0], spacing[1], spacing[2]).asDiagonal();
    const std::vector<float> to_set = distance_map(set, {{}, grid.size}, mm);
    const std::vector<float> to_others = distance_map(others, {{}, grid.size}, mm);
    for (const bool both : {false, true}) {
      for (const float reach : {3.2f, 1000.0f}) {
        std::vector<float> square(set.size()), buffer(set.size());
        squared_distance_to_other_side(executor, set.data(), grid, spacing, reach, both, square.data(), buffer.data());
        int within = 0;
        for (std::size_t v = 0; v < set.size(); ++v) {
          const float expected = !set[v] ? to_set[v] : both ? to_others[v] : 0, mine = std::sqrt(square[v]);
          if (expected < reach) {
            ASSERT_NEAR(mine, expected, 1e-5 * expected) << v;
            within += expected > 0;
          } else {
            ASSERT_GE(mine, reach) << v;
          }
        }
        EXPECT_GT(within, 500);
      }
    }
  }
}

/// Includes voxels beyond the reach. Values may differ by one because of rounding.
TEST(FieldValues, EqualThoseOfTheDistanceMap) {
  for (const std::array<double, 3>& spacing : kSpacings) {
    VolumeGeometry geometry;
    geometry.size = {160, 12, 10};
    for (int a = 0; a < 3; ++a) geometry.spacing_mm[a] = spacing[a];
    const VoxelBox box{{0, 0, 0}, geometry.size};
    std::vector<std::uint8_t> object = blobs({box.size}, 0.05f, 6);
    for (std::size_t v = 0; v < object.size(); ++v) object[v] &= v % 160 < 24;
    std::vector<float> probability = noise_of(object.size(), 8), squares(object.size()), buffer(object.size());
    for (float& p : probability) p = std::clamp(0.5f + 0.3f * p, 0.0f, 1.0f);
    std::vector<std::uint16_t> values(object.size(), 7);
    field_values(executor, object.data(), probability.data(), {box.size}, spacing, field_value_of(geometry),
                 squares.data(), buffer.data(), values.data());
    const std::vector<std::uint16_t> expected =
        field_values(object, probability, box, geometry, field_value_of(geometry), run_serially());
    for (std::size_t v = 0; v < values.size(); ++v) ASSERT_NEAR(values[v], expected[v], 1) << v;
    EXPECT_GT(std::ranges::count(values, 0), 100);
  }
}

}  // namespace
}  // namespace simplexseg
