// SPDX-License-Identifier: Apache-2.0
#include "evidence/conductances.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "evidence/quantile.h"

namespace simplexseg {
namespace {

constexpr float kLeastConductance = 1e-5f;  // keeps every finite voxel connected

}  // namespace

float inner_difference(const BoxGrid& grid, const std::array<double, 3>& spacing_mm, std::span<const float> image,
                       std::span<const Known> known) {
  const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
  std::vector<float> differences;
  const int n = static_cast<int>(known.size());
  for (int v = 0; v < n; ++v) {
    if (known[v] != Known::Inside) continue;
    for (int a = 0; a < 3; ++a) {
      if (spacing_mm[a] >= 2 * least || grid.size[a] == 1) continue;
      // The last voxel of a row and the first of the next are never both inside: they lie on two sides of the box.
      const int u = v + grid.stride(a);
      if (u < n && known[u] == Known::Inside) differences.push_back(std::fabs(image[u] - image[v]));
    }
  }
  if (differences.size() < 20) return 0;
  return quantile(differences, 0.75);
}

double sharpness_of(float inner_difference, const EvidenceSettings& settings) {
  if (settings.sharpness <= 0) return settings.beta;
  const double edge = settings.sharpness * inner_difference;
  return std::clamp(1 / (2 * edge * edge), settings.least_beta, settings.largest_beta);
}

void set_edges(RandomWalker& walker, const std::array<double, 3>& spacing_mm, std::span<const float> image,
               std::span<const std::uint8_t> finite, double beta, double pull, const RunJobs& run) {
  const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
  const BoxGrid& grid = walker.grid();
  for (int axis = 0; axis < 3; ++axis) {
    const float scale = static_cast<float>((least / spacing_mm[axis]) * (least / spacing_mm[axis]));
    const int stride = grid.stride(axis);
    for_each_index(run, grid.count() - stride,
                   [scale, stride, fall = static_cast<float>(-beta), value = image.data(), finite = finite.data(),
                    weight = walker.weights(axis).data()](int v) {
                     const float d = value[v + stride] - value[v];
                     const float w = scale * (std::exp(fall * d * d) + kLeastConductance);
                     weight[v] = finite[v] && finite[v + stride] ? w : 0.0f;
                   });
  }
  // In proportion to the mean conductance: on an edge, which conducts little, the neighbours still say more than the
  // prior, which knows nothing of what lies half on either side.
  for_each_index(
      run, grid.count(),
      [pull = walker.pull().data(), wx = walker.weights(0).data(), row = grid.row(), wy = walker.weights(1).data(),
       plane = grid.plane(), wz = walker.weights(2).data(), gamma = static_cast<float>(pull / 6)](int v) {
        pull[v] = gamma * (wx[v] + wx[v - 1] + wy[v] + wy[v - row] + wz[v] + wz[v - plane]);
      });
}

}  // namespace simplexseg
