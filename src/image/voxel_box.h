// SPDX-License-Identifier: Apache-2.0
// Unions, common parts and margins of boxes of voxels.
#pragma once
#include <array>

#include "image/distance_map.h"

namespace simplexseg {

/// Smallest box around two boxes; an empty box adds nothing.
VoxelBox united(const VoxelBox& a, const VoxelBox& b);
/// Common part of two boxes; size 0 if there is none.
VoxelBox common(const VoxelBox& a, const VoxelBox& b);
/// Box with `margin` voxels around it, clipped at a grid of this size.
VoxelBox widened(const VoxelBox& box, const std::array<int, 3>& margin, const std::array<int, 3>& grid);

}  // namespace simplexseg
