// SPDX-License-Identifier: Apache-2.0
#include "field/voxel_features.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "field/parallel/cpu_executor.h"

namespace simplexseg {
namespace {

/// Length of the gradient per smallest spacing, by central differences, one-sided at the border.
std::vector<float> gradient_length(const std::vector<float>& f, const BoxGrid& grid,
                                   const std::array<double, 3>& spacing_mm, const RunJobs& run) {
  const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
  std::vector<float> length(f.size());
  run(grid.size[2], [&](int k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const int v = (k * grid.size[1] + j) * grid.size[0] + i;
        const std::array<int, 3> at{i, j, k};
        float sum = 0;
        for (int a = 0; a < 3; ++a) {
          const int backward = at[a] > 0, forward = at[a] + 1 < grid.size[a];
          if (backward + forward == 0) continue;
          const float change = f[v + forward * grid.stride(a)] - f[v - backward * grid.stride(a)];
          const float slope =
              change * static_cast<float>(least / spacing_mm[a]) / static_cast<float>(backward + forward);
          sum += slope * slope;
        }
        length[v] = std::sqrt(sum);
      }
    }
  });
  return length;
}

/// Sum of value(v) over all 0 <= v < n.
template <class Value>
double sum_of(const RunJobs& run, int n, const Value& value) {
  const ReportProgress no_progress;
  return CpuGrid(run, no_progress).totals(n, [value](int v) { return Contribution{value(v), 0}; }).sum;
}

void standardise(std::vector<float>& f, const RunJobs& run) {
  const int n = static_cast<int>(f.size());
  const double mean = sum_of(run, n, [x = f.data()](int v) { return x[v]; }) / n;
  const float centre = static_cast<float>(mean);
  const double square = sum_of(run, n, [x = f.data(), centre](int v) { return (x[v] - centre) * (x[v] - centre); }) / n;
  const float scale = square > 1e-12 ? static_cast<float>(1 / std::sqrt(square)) : 0.0f;
  for_each_index(run, n, [x = f.data(), centre, scale](int v) { x[v] = (x[v] - centre) * scale; });
}

}  // namespace

FeatureLists voxel_features(const std::vector<float>& image, const BoxGrid& grid,
                            const std::array<double, 3>& spacing_mm, const RunJobs& run) {
  const auto smoothed = [&](std::vector<float> values, double voxels) {
    smooth_by_least_spacing(values, grid, spacing_mm, voxels, run);
    return values;
  };
  FeatureLists features;
  for (const double scale : {0.7, 1.5, 3.0}) features.push_back(smoothed(image, scale));
  std::vector<float> deviation(image.size());
  std::transform(image.begin(), image.end(), deviation.begin(), [](float x) { return x * x; });
  deviation = smoothed(std::move(deviation), 1.5);
  for (std::size_t v = 0; v < deviation.size(); ++v)
    deviation[v] = std::sqrt(std::max(deviation[v] - features[1][v] * features[1][v], 0.0f));
  for (const double scale : {1.0, 2.0})
    features.push_back(gradient_length(smoothed(image, scale), grid, spacing_mm, run));
  features.push_back(std::move(deviation));
  for (std::vector<float>& f : features) standardise(f, run);
  return features;
}

}  // namespace simplexseg
