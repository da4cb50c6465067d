// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstddef>

#include "image/distance_map.h"

namespace simplexseg {

/// Calls row(in_inner, in_outer) for each row (along i) of the inner box. The arguments are the offsets of the first
/// voxel of the row in the inner box and in the outer box, which encloses the inner box on the same grid.
template <class Row>
void for_each_row(const VoxelBox& inner, const VoxelBox& outer, const Row& row) {
  for (int k = 0; k < inner.size[2]; ++k)
    for (int j = 0; j < inner.size[1]; ++j)
      row(inner.offset(0, j, k), outer.offset(inner.first[0] - outer.first[0], j + inner.first[1] - outer.first[1],
                                              k + inner.first[2] - outer.first[2]));
}

/// Copies `from`, the values of the inner box, into `to`, the values of the outer box.
template <class T>
void copy_into_outer(const T* from, const VoxelBox& inner, T* to, const VoxelBox& outer) {
  for_each_row(inner, outer, [&](std::size_t in_inner, std::size_t in_outer) {
    std::copy_n(from + in_inner, inner.size[0], to + in_outer);
  });
}

/// Copies the part of `from`, the values of the outer box, that lies in the inner box to `to`.
template <class T>
void copy_from_outer(const T* from, const VoxelBox& outer, T* to, const VoxelBox& inner) {
  for_each_row(inner, outer, [&](std::size_t in_inner, std::size_t in_outer) {
    std::copy_n(from + in_outer, inner.size[0], to + in_inner);
  });
}

}  // namespace simplexseg
