// SPDX-License-Identifier: Apache-2.0
#include "field/shape_prior.h"

#include <cmath>

namespace simplexseg {

std::vector<float> ShapePrior::at_cells(const VolumeGeometry& cells, const RunJobs& run) const {
  std::vector<float> values(cells.voxel_count(), outside);
  const Eigen::Affine3d index = grid.index_from_world() * cells.world_from_index();
  const std::array<std::ptrdiff_t, 3> stride{1, grid.size[0], std::ptrdiff_t(grid.size[0]) * grid.size[1]};
  run(cells.size[2], [&](int k) {
    std::size_t v = std::size_t(k) * cells.size[1] * cells.size[0];
    for (int j = 0; j < cells.size[1]; ++j)
      for (int i = 0; i < cells.size[0]; ++i, ++v) {
        const Eigen::Vector3d at = index * Eigen::Vector3d(i, j, k);
        std::ptrdiff_t first = 0;
        std::array<std::ptrdiff_t, 3> step;
        std::array<float, 3> share;
        bool inside = true;
        for (int a = 0; a < 3 && inside; ++a) {
          inside = at[a] >= 0 && at[a] <= grid.size[a] - 1;
          if (!inside) break;
          const auto low = static_cast<std::ptrdiff_t>(at[a]);
          share[a] = static_cast<float>(at[a] - static_cast<double>(low));
          step[a] = low + 1 < grid.size[a] ? stride[a] : 0;
          first += low * stride[a];
        }
        if (!inside) continue;
        float sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
          float weight = 1;
          std::ptrdiff_t cell = first;
          for (int a = 0; a < 3; ++a) {
            const bool high = (corner >> a & 1) != 0;
            weight *= high ? share[a] : 1 - share[a];
            cell += high ? step[a] : 0;
          }
          sum += weight * log_odds[cell];
        }
        values[v] = sum;
      }
  });
  return values;
}

}  // namespace simplexseg
