// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "image/distance_map.h"
#include "image/volume.h"

namespace simplexseg {

/// A binary mask on a grid: one byte a voxel, 0 or 1, i fastest.
struct Mask {
  VolumeGeometry geometry;
  std::vector<std::uint8_t> voxels;
};

/// The smallest box around the set voxels of both masks, which are on one grid; size 0 when there is none.
VoxelBox bounding_box(const Mask& a, const Mask& b);

/// Voxels equal to `label`; with no label, all voxels that are neither 0 nor NaN.
Mask mask_of(const Volume& labels, std::optional<double> label);

/// The mask whose voxels are those of a box of the grid (0 or 1, i fastest), and 0 beyond it.
Mask mask_of(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const std::uint8_t> voxels);

}  // namespace simplexseg
