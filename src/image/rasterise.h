// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "image/mask.h"

namespace simplexseg {

struct SimplexMesh;

/// Mask of the voxels whose centre lies inside the closed surface, for any direction matrix. Inside means a non-zero
/// winding number along i, so overlaps of a folded mesh are filled. A centre within 2^-14 voxel of a face belongs to
/// one side only: touching surfaces neither share a voxel nor leave a gap. Parts of the mesh outside the grid are
/// ignored. Throws Error if a position is not finite or the geometry is not valid.
Mask rasterise(const SimplexMesh& mesh, const VolumeGeometry& geometry);

/// Fraction of each voxel of a grid inside the closed surface, 0..1, i fastest: exact along i, mean of 16 lines across
/// it. Throws the errors of rasterise().
std::vector<float> inside_fractions(const SimplexMesh& mesh, const VolumeGeometry& geometry);

}  // namespace simplexseg
