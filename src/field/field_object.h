// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "field/marked_voxels.h"
#include "image/distance_map.h"

namespace simplexseg {

/// Largest number of voxels between a side of the box and a voxel that is near it.
inline constexpr int kNearSide = 4;

/// Object mask of a field: voxels above 0.5 that are connected (six neighbours) to an inside mark, with their holes
/// filled except those that contain an outside mark.
struct FieldObject {
  std::vector<std::uint8_t> voxels;  ///< 0 or 1 for each voxel of the box
  VoxelBox bounds{};                 ///< bounding box of the object, indices of the volume; size 0 without an object
  std::size_t count = 0;             ///< number of voxels of the object
  double border_share = 0;           ///< share of the object in the voxels near the sides of the box
};

/// Computes the object mask of a field on the CPU.
FieldObject object_of_field(std::span<const float> field, std::span<const Constraint> constraints, const VoxelBox& box);

}  // namespace simplexseg
