// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "image/distance_map.h"
#include "image/volume.h"

namespace simplexseg {

/// Binary mask on a grid: one byte per voxel, 0 or 1, i fastest.
struct Mask {
  VolumeGeometry geometry;
  std::vector<std::uint8_t> voxels;
};

/// Smallest box around the set voxels of two masks on the same grid; a box of size 0 if both are empty.
VoxelBox bounding_box(const Mask& a, const Mask& b);

/// Mask of the voxels that equal `label` or, without a label, of all voxels that are neither 0 nor NaN.
Mask mask_of(const Volume& labels, std::optional<double> label);

/// Mask on a grid from the voxels of a box (0 or 1, i fastest) inside this grid; 0 outside the box.
Mask mask_of(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const std::uint8_t> voxels);

}  // namespace simplexseg
