// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <type_traits>

#include "core/vec3.h"
#include "image/cell_grid.h"

namespace simplexseg {

/// Trilinear resampling from a box of cells to a box of other cells of the same volume. Values of 0 are unknown and
/// have no weight; the result is 0 where all eight are unknown, and outside the box. Exact for equal cells.
struct CellResampling {
  int from_size[3], to_size[3];
  float scale[3], shift[3];  ///< index in the box `from`: scale * index in the box `to` + shift

  CellResampling(const CellSize& from_cell, const VoxelBox& from, const CellSize& to_cell, const VoxelBox& to) {
    for (int a = 0; a < 3; ++a) {
      from_size[a] = from.size[a], to_size[a] = to.size[a];
      const double ratio = to_cell[a] / from_cell[a];
      scale[a] = static_cast<float>(ratio);
      shift[a] = static_cast<float>((to.first[a] + 0.5) * ratio - 0.5 - from.first[a]);
    }
  }

  /// Value of cell v of the box `to`.
  template <class T>
  SIMPLEXSEG_HD T operator()(int v, const T* from) const {
    static_assert(std::is_integral_v<T>);
    const int at[3]{v % to_size[0], v / to_size[0] % to_size[1], v / (to_size[0] * to_size[1])};
    int low[3], high[3];
    float share[3];
    for (int a = 0; a < 3; ++a) {
      const float x = scale[a] * static_cast<float>(at[a]) + shift[a];
      if (x < -0.5f || x > static_cast<float>(from_size[a]) - 0.5f) return 0;
      const float inner = smaller(larger(x, 0.0f), static_cast<float>(from_size[a] - 1));
      low[a] = static_cast<int>(inner);
      high[a] = smaller(low[a] + 1, from_size[a] - 1);
      share[a] = inner - static_cast<float>(low[a]);
    }
    float sum = 0, weights = 0;
    for (int corner = 0; corner < 8; ++corner) {
      int u = 0;
      float weight = 1;
      for (int a = 2; a >= 0; --a) {
        const bool upper = (corner >> a & 1) != 0;
        u = u * from_size[a] + (upper ? high[a] : low[a]);
        weight *= upper ? share[a] : 1 - share[a];
      }
      if (from[u] == 0) continue;
      sum += weight * static_cast<float>(from[u]);
      weights += weight;
    }
    return weights > 0 ? static_cast<T>(sum / weights + 0.5f) : T{0};
  }
};

}  // namespace simplexseg
