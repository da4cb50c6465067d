// SPDX-License-Identifier: Apache-2.0
// Grids of cells: blocks of the voxels of a volume.
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "image/distance_map.h"
#include "image/mask.h"
#include "image/volume.h"

namespace simplexseg {

/// Edge lengths of a cell along i, j, k, voxels; each is at least 1 and may be fractional. Cell 0 begins where voxel 0
/// begins, and the last cell along an axis may extend beyond the volume.
using CellSize = std::array<double, 3>;
inline constexpr CellSize kVoxelCells{1, 1, 1};

/// Grid of all cells of a volume; the geometry of the volume itself for cells of one voxel.
VolumeGeometry cell_geometry(const VolumeGeometry& volume, const CellSize& cell);

/// Smallest box of cells that contains a box of voxels of the volume.
VoxelBox cells_around(const VoxelBox& voxels, const CellSize& cell, const std::array<int, 3>& volume_size);
/// Smallest box of voxels of the volume that contains a box of cells.
VoxelBox voxels_around(const VoxelBox& cells, const CellSize& cell, const std::array<int, 3>& volume_size);

/// Index of the centre of a voxel in the grid of cells: scale * voxel + shift.
struct VoxelToCell {
  std::array<double, 3> scale, shift;
  explicit VoxelToCell(const CellSize& cell) : scale{}, shift{} {
    for (int a = 0; a < 3; ++a) scale[a] = 1 / cell[a], shift[a] = 0.5 * scale[a] - 0.5;
  }
  double operator()(int axis, double voxel) const { return scale[axis] * voxel + shift[axis]; }
};

/// Mask of the voxels of a volume at whose centres the trilinear interpolant of `values` exceeds `threshold`.
/// `values`: one for each cell of the box, in which the interpolant is constant beyond the outermost cell centres; no
/// voxel outside the box is set.
Mask mask_above(const VolumeGeometry& volume, const CellSize& cell, const VoxelBox& box,
                std::span<const std::uint16_t> values, float threshold);

}  // namespace simplexseg
