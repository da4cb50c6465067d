// SPDX-License-Identifier: Apache-2.0
#include "evidence/field_object.h"

#include <algorithm>

#include "evidence/connected.h"

namespace simplexseg {

FieldObject object_of_field(std::span<const float> field, std::span<const Known> known, const VoxelBox& box) {
  const int n = static_cast<int>(field.size());
  FieldObject object{std::vector<std::uint8_t>(n)};
  std::vector<std::uint8_t> start(n), open(n);
  for (int v = 0; v < n; ++v) {
    object.voxels[v] = field[v] > 0.5f;
    start[v] = known[v] == Known::Inside;
  }
  keep_connected(object.voxels, start, box.size);
  for (int v = 0; v < n; ++v) {
    open[v] = !object.voxels[v];
    start[v] = known[v] == Known::Outside;
  }
  for (int k = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j) {
      const auto row = start.begin() + static_cast<std::ptrdiff_t>(box.offset(0, j, k));
      if (k == 0 || j == 0 || k == box.size[2] - 1 || j == box.size[1] - 1)
        std::fill_n(row, box.size[0], 1);
      else
        row[0] = row[box.size[0] - 1] = 1;
    }
  keep_connected(open, start, box.size);

  std::array<int, 3> low = box.size, high{-1, -1, -1};
  std::size_t near = 0, near_object = 0;
  for (int k = 0, v = 0; k < box.size[2]; ++k) {
    for (int j = 0; j < box.size[1]; ++j) {
      const int row_to_side = std::min({j, k, box.size[1] - 1 - j, box.size[2] - 1 - k});
      for (int i = 0; i < box.size[0]; ++i, ++v) {
        const bool is = !open[v];
        object.voxels[v] = is;
        const bool at_side = std::min({row_to_side, i, box.size[0] - 1 - i}) <= kNearSide;
        near += at_side;
        near_object += at_side && is;
        if (!is) continue;
        low = {std::min(low[0], i), std::min(low[1], j), std::min(low[2], k)};
        high = {std::max(high[0], i), std::max(high[1], j), std::max(high[2], k)};
      }
    }
  }
  if (high[0] >= 0) {
    for (int a = 0; a < 3; ++a) {
      object.around.first[a] = box.first[a] + low[a];
      object.around.size[a] = high[a] - low[a] + 1;
    }
  }
  if (near > 0) object.border_share = static_cast<double>(near_object) / static_cast<double>(near);
  return object;
}

}  // namespace simplexseg
