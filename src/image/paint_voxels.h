// SPDX-License-Identifier: Apache-2.0
// Voxels that paint sets, for paint that is not the path of a brush.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "image/mask.h"

namespace simplexseg {

/// Effect of paint on a voxel.
enum class VoxelPaint : std::uint8_t { None, Inside, Outside };

/// Voxels of a box that paint sets, i fastest.
struct PaintVoxels {
  VolumeGeometry box;  ///< grid of the box; without a header
  std::vector<VoxelPaint> voxels;
};

/// Grid of a box of voxels that lies in a grid.
VolumeGeometry grid_of_box(const VolumeGeometry& grid, const VoxelBox& box);

/// Voxels in which two masks on the same grid differ, in the smallest box around them; inside where `after` is set.
/// Null if the masks are equal.
std::shared_ptr<const PaintVoxels> difference_of(const Mask& before, const Mask& after);

/// Run lengths of voxels in the order unset, inside, outside, unset ...; their sum is the number of voxels.
std::vector<std::uint32_t> runs_of(std::span<const VoxelPaint> voxels);
/// Voxels from their run lengths. Throws Error unless they add up to `count`.
std::vector<VoxelPaint> voxels_of_runs(std::span<const std::uint32_t> runs, std::size_t count);

}  // namespace simplexseg
