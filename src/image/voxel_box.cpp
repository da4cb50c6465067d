// SPDX-License-Identifier: Apache-2.0
#include "image/voxel_box.h"

#include <algorithm>

namespace simplexseg {

VoxelBox united(const VoxelBox& a, const VoxelBox& b) {
  if (a.voxel_count() == 0 || b.voxel_count() == 0) return a.voxel_count() == 0 ? b : a;
  VoxelBox box{};
  for (int axis = 0; axis < 3; ++axis) {
    box.first[axis] = std::min(a.first[axis], b.first[axis]);
    box.size[axis] = std::max(a.first[axis] + a.size[axis], b.first[axis] + b.size[axis]) - box.first[axis];
  }
  return box;
}

VoxelBox common(const VoxelBox& a, const VoxelBox& b) {
  VoxelBox box{};
  for (int axis = 0; axis < 3; ++axis) {
    box.first[axis] = std::max(a.first[axis], b.first[axis]);
    const int end = std::min(a.first[axis] + a.size[axis], b.first[axis] + b.size[axis]);
    if (end <= box.first[axis]) return {};
    box.size[axis] = end - box.first[axis];
  }
  return box;
}

VoxelBox widened(const VoxelBox& box, const std::array<int, 3>& margin, const std::array<int, 3>& grid) {
  VoxelBox wide{};
  for (int a = 0; a < 3; ++a) {
    wide.first[a] = box.first[a] - margin[a];
    wide.size[a] = box.size[a] + 2 * margin[a];
  }
  return common(wide, {{0, 0, 0}, grid});
}

}  // namespace simplexseg
