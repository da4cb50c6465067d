// SPDX-License-Identifier: Apache-2.0
// The box of voxels that the field is solved on: it finds itself.
#pragma once
#include <span>

#include "field/evidence_settings.h"
#include "field/marks.h"
#include "image/cell_grid.h"
#include "image/distance_map.h"
#include "image/volume.h"

namespace simplexseg {

/// Around all marks, within the volume, with a margin of a share of their extent and no less than so many of the
/// smallest voxels.
VoxelBox box_around_marks(std::span<const Mark> marks, const VolumeGeometry& geometry, double margin_share,
                          double least_margin);

/// The smallest box that holds two others; one of size 0 counts as none.
VoxelBox box_around(const VoxelBox& a, const VoxelBox& b);

/// Cells for an object of this scale (seed_scale()) in a box of voxels: the voxels, or the smallest cells with which
/// the box has at most EvidenceSettings::max_cells and a block of the prior is a whole number of cells wide, at most
/// kWidestBlock. The blocks, and so the result, then hardly depend on the spacing of the image. All edges of a cell are
/// equally long (mm), except along axes of larger voxels.
CellSize cell_size_for(const VoxelBox& voxels, const VolumeGeometry& volume, double reach_mm,
                       const EvidenceSettings& settings);

/// Moves each side that `object` (a box within the volume) has come near: nearer than 0.15 of its extent or five of the
/// smallest voxels; to 0.3 of the extent or ten voxels, at most to the volume's side. Returns `box` where none has.
VoxelBox grow_around(const VoxelBox& box, const VoxelBox& object, const VolumeGeometry& geometry);

}  // namespace simplexseg
