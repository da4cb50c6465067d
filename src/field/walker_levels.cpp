// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "field/walker_kernels.h"

namespace simplexseg {

std::vector<WalkerLevelShape> walker_levels(const BoxGrid& grid, const std::array<double, 3>& spacing_mm) {
  const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
  std::array<double, 3> strength;
  for (int a = 0; a < 3; ++a) strength[a] = (least / spacing_mm[a]) * (least / spacing_mm[a]);
  std::vector<WalkerLevelShape> levels;
  BoxGrid at = grid;
  while (true) {
    WalkerLevelShape& level = levels.emplace_back();
    level.grid = at;
    if (at.count() <= kCoarsestVoxels) return levels;
    double strongest = 0;
    for (int a = 0; a < 3; ++a)
      if (at.size[a] > 1) strongest = std::max(strongest, strength[a]);
    for (int a = 0; a < 3; ++a) {
      if (at.size[a] == 1 || strength[a] < 0.25 * strongest) continue;
      level.halved[a] = true;
      at.size[a] = (at.size[a] + 1) / 2;
      strength[a] /= 4;
    }
  }
}

}  // namespace simplexseg
