// SPDX-License-Identifier: Apache-2.0
#include "field/parallel/smooth.h"
#include "field/parallel/cpu_executor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "field/box_image.h"
#include "references.h"

namespace simplexseg {
namespace {

std::vector<float> noise(const BoxGrid& grid, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<float> values(grid.count());
  for (float& x : values) x = static_cast<float>(random()) / 4294967296.0f;
  return values;
}

/// Gaussian along each axis, cut at three deviations, the outermost values being repeated beyond the grid.
std::vector<double> reference(const std::vector<float>& from, const BoxGrid& grid, const std::array<double, 3>& sigma) {
  std::vector<double> values(from.begin(), from.end());
  for (int a = 0; a < 3; ++a) {
    if (sigma[a] < 0.2) continue;
    const int reach = std::max(1, static_cast<int>(std::ceil(3 * sigma[a])));
    const std::vector<double> before = values;
    each_index(grid, [&](int i, int j, int k, int v) {
      const int at = a == 0 ? i : a == 1 ? j : k;
      double sum = 0, weights = 0;
      for (int d = -reach; d <= reach; ++d) {
        const int to = std::clamp(at + d, 0, grid.size[a] - 1);
        const double weight = std::exp(-d * d / (2 * sigma[a] * sigma[a]));
        sum += weight * before[v + (to - at) * grid.stride(a)];
        weights += weight;
      }
      values[v] = sum / weights;
    });
  }
  return values;
}

TEST(Smooth, IsAGaussianAlongEachAxis) {
  for (const int cells : {1, 2, 9, 15, 16, 17, 33, 70})
    for (const std::array<double, 3>& sigma :
         {std::array{1.3, 0.7, 0.1}, std::array{4.0, 4.0, 4.0}, std::array{0.5, 2.0, 1.0}}) {
      const BoxGrid grid{{cells, 18, 9}};
      const std::vector<float> a = noise(grid, 1), b = noise(grid, 2);
      const std::vector<double> of_a = reference(a, grid, sigma), of_b = reference(b, grid, sigma);
      std::vector<float> by_box_image = a;
      smooth(by_box_image, grid, sigma, run_serially());
      for (const RunJobs& run : {run_serially(), run_in_reverse(), run_on_threads(8)}) {
        const CpuFieldExecutor executor(run);
        SmoothedFields<CpuFieldExecutor, 2> fields(executor, grid);
        executor.upload<float>(a, fields.data(0));
        executor.upload<float>(b, fields.data(1));
        fields.smooth(sigma);
        for (int v = 0; v < grid.count(); ++v) {
          ASSERT_NEAR(fields.data(0)[v], of_a[v], 3e-6) << cells;
          ASSERT_NEAR(fields.data(1)[v], of_b[v], 3e-6) << cells;
          ASSERT_NEAR(by_box_image[v], of_a[v], 3e-6) << cells;
        }
      }
    }
}

TEST(Smooth, UsesTheLeastSpacing) {
  const BoxGrid grid{{20, 18, 9}};
  const std::vector<float> values = noise(grid, 1);
  const std::vector<double> expected = reference(values, grid, {1.5, 0.75, 0.5});
  const CpuFieldExecutor executor;
  SmoothedFields<CpuFieldExecutor, 1> fields(executor, grid);
  executor.upload<float>(values, fields.data(0));
  fields.smooth_by_least_spacing({1, 2, 3}, 1.5);
  for (int v = 0; v < grid.count(); ++v) ASSERT_NEAR(fields.data(0)[v], expected[v], 3e-6);
}

}  // namespace
}  // namespace simplexseg
