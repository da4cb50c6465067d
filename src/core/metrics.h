// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/distance_map.h"
#include "core/volume.h"

namespace simplexseg {

struct SimplexMesh;

/// A binary mask on a grid: one byte a voxel, 0 or 1, i fastest.
struct Mask {
  VolumeGeometry geometry;
  std::vector<std::uint8_t> voxels;
};

/// The smallest box that holds the set voxels of both masks, which are on one grid; size 0 when there is none.
VoxelBox bounding_box(const Mask& a, const Mask& b);

/// Voxels equal to `label`; with no label, all voxels that are neither 0 nor NaN.
Mask mask_of(const Volume& labels, std::optional<double> label);

/// The voxels whose centre lies inside the closed surface (non-zero winding along i, so that the overlaps of a folded
/// mesh stay filled), under any direction matrix. A centre on a face, to within 2^-14 voxel, belongs to one side only,
/// so touching surfaces never share a voxel nor leave a gap. The part of the mesh outside the grid is cut off. Throws
/// Error when a position is not finite.
Mask rasterise(const SimplexMesh& mesh, const VolumeGeometry& geometry);

/// Agreement of two masks on one grid. Boundary: voxels of the mask with a 6-neighbour outside it, the image border
/// counting as outside; distances between voxel centres in mm (full direction matrix). HD95 symmetric is the larger of
/// the two directed 95th percentiles (linear interpolation), ASSD the mean of the two directed means. With one mask
/// empty, distances are infinite and Dice is 0; with both empty, distances are 0 and Dice is 1.
struct Agreement {
  double dice;
  double hd_mm, hd95_mm, assd_mm;
  double hd_directed_mm, hd95_directed_mm, asd_directed_mm;   ///< reference boundary to test boundary
  double reference_mm3, test_mm3;
};
/// Throws Error when the two grids differ.
Agreement compare(const Mask& reference, const Mask& test);
/// The Dice coefficient alone: cheap.
double dice(const Mask& reference, const Mask& test);

}  // namespace simplexseg
