// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "field/marked_voxels.h"
#include "image/distance_map.h"

namespace simplexseg {

/// Voxels of a box are near a side of it up to so many steps away from it.
inline constexpr int kNearSide = 4;

/// The object that a field says: the voxels above 0.5 that are connected (six neighbours) to an inside mark, and the
/// holes in them that no outside mark lies in.
struct FieldObject {
  std::vector<std::uint8_t> voxels;  ///< of the box, 0 or 1
  VoxelBox around{};                 ///< the smallest box about them, in the volume's indices; size 0 without any
  std::size_t count = 0;             ///< number of voxels of the object
  double border_share = 0;           ///< of the voxels within four of a side of the box, how many are of the object
};

/// Finds the object of a field on the CPU.
FieldObject object_of_field(std::span<const float> field, std::span<const Constraint> known, const VoxelBox& box);

}  // namespace simplexseg
