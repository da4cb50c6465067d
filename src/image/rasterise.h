// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "image/mask.h"

namespace simplexseg {

struct SimplexMesh;

/// The voxels whose centre lies inside the closed surface (non-zero winding along i, so that the overlaps of a folded
/// mesh stay filled), under any direction matrix. A centre on a face, to within 2^-14 voxel, belongs to one side only,
/// so touching surfaces never share a voxel nor leave a gap. The part of the mesh outside the grid is cut off. Throws
/// Error when a position is not finite.
Mask rasterise(const SimplexMesh& mesh, const VolumeGeometry& geometry);

}  // namespace simplexseg
