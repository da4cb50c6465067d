// SPDX-License-Identifier: Apache-2.0
#include "evidence/conductances.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "evidence/find_value.h"
#include "evidence/quantile.h"
#include "evidence/walker_kernels.h"

namespace simplexseg {
float inner_difference(const BoxGrid& grid, const std::array<double, 3>& spacing_mm, std::span<const float> image,
                       std::span<const Constraint> known) {
  const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
  std::vector<float> differences;
  const int n = static_cast<int>(known.size());
  const auto next_inside = [&](int from) { return find_value(known, Constraint::Inside, from, n); };  // few are
  for (int v = next_inside(0); v < n; v = next_inside(v + 1)) {
    for (int a = 0; a < 3; ++a) {
      if (spacing_mm[a] >= 2 * least || grid.size[a] == 1) continue;
      // The last voxel of a row and the first of the next are never both inside: they lie on two sides of the box.
      const int u = v + grid.stride(a);
      if (u < n && known[u] == Constraint::Inside) differences.push_back(std::fabs(image[u] - image[v]));
    }
  }
  if (static_cast<int>(differences.size()) < kLeastDifferences) return 0;
  return quantile(differences, kShareOfDifferences);
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
    const Conductance conductance{image.data(), finite.data(), scale, static_cast<float>(-beta), stride};
    for_each_index(run, grid.count() - stride,
                   [conductance, weight = walker.weights(axis).data()](int v) { weight[v] = conductance(v); });
    std::ranges::fill(walker.weights(axis).last(stride), 0.0f);
  }
  const LevelView edges{
      grid.row(), grid.plane(), walker.weights(0).data(), walker.weights(1).data(), walker.weights(2).data(), nullptr};
  for_each_index(run, grid.count(), PullOfEdges{edges, static_cast<float>(pull / 6), walker.pull().data()});
}

}  // namespace simplexseg
