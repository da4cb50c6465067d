// SPDX-License-Identifier: Apache-2.0
#include "evidence/field_object.h"

#include <algorithm>

namespace simplexseg {
namespace {

/// Sets `set` for all voxels that can be reached from those in `stack`, which are set, over voxels that may(v).
template <class May>
void flood(std::vector<std::uint8_t>& set, std::vector<int>& stack, const std::array<int, 3>& size, May&& may) {
  const std::array<int, 3> stride{1, size[0], size[0] * size[1]};
  while (!stack.empty()) {
    const int v = stack.back();
    stack.pop_back();
    const std::array<int, 3> at{v % size[0], v / size[0] % size[1], v / stride[2]};
    for (int a = 0; a < 3; ++a) {
      for (const int way : {-1, 1}) {
        if (at[a] + way < 0 || at[a] + way >= size[a]) continue;
        const int u = v + way * stride[a];
        if (set[u] || !may(u)) continue;
        set[u] = 1;
        stack.push_back(u);
      }
    }
  }
}

}  // namespace

FieldObject object_of_field(std::span<const float> field, std::span<const Known> known, const VoxelBox& box) {
  const int n = static_cast<int>(field.size());
  FieldObject object{std::vector<std::uint8_t>(n)};
  std::vector<int> stack;
  const auto start = [&stack](std::vector<std::uint8_t>& set, int v) {
    set[v] = 1;
    stack.push_back(v);
  };
  for (int v = 0; v < n; ++v)
    if (known[v] == Known::Inside && field[v] > 0.5f) start(object.voxels, v);
  flood(object.voxels, stack, box.size, [&](int v) { return field[v] > 0.5f; });

  const auto to_side = [&](int i, int j, int k) {
    int least = i;
    const std::array<int, 3> at{i, j, k};
    for (int a = 0; a < 3; ++a) least = std::min({least, at[a], box.size[a] - 1 - at[a]});
    return least;
  };
  std::vector<std::uint8_t> open(n);
  for (int k = 0, v = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j)
      for (int i = 0; i < box.size[0]; ++i, ++v)
        if (!object.voxels[v] && (known[v] == Known::Outside || to_side(i, j, k) == 0)) start(open, v);
  flood(open, stack, box.size, [&](int v) { return !object.voxels[v]; });

  std::array<int, 3> low = box.size, high{-1, -1, -1};
  std::size_t near = 0, near_object = 0;
  for (int k = 0, v = 0; k < box.size[2]; ++k) {
    for (int j = 0; j < box.size[1]; ++j) {
      for (int i = 0; i < box.size[0]; ++i, ++v) {
        object.voxels[v] = !open[v];
        const bool at_side = to_side(i, j, k) <= 4;
        near += at_side;
        if (open[v]) continue;
        near_object += at_side;
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
