// SPDX-License-Identifier: Apache-2.0
// Sides of the volume that cut an object.
#pragma once
#include <cstdint>
#include <span>

#include "field/marked_voxels.h"

namespace simplexseg {

/// Returns the sides of the volume, among those of the box that are not `open` yet, through which the object continues.
/// From its section near the side, cells that resemble its inside lead to the side, without becoming much fewer, and
/// most cells around them resemble its outside; inside and outside are those of the intensities in a slab along the
/// side, which must differ (docs/mathematics.md, section 8.3). `geometry`: grid of all cells of the volume; `object`
/// (0 or 1), `image` (smoothed, 0 to 1) and `constraints` are of the cells of `box`.
BoxSides cut_sides(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const std::uint8_t> object,
                   std::span<const float> image, std::span<const Constraint> constraints, const BoxSides& open);

/// Whether an object with this bounding box, in indices of cells of the volume, is near a side of the volume that is a
/// side of the box and not open: otherwise cut_sides() finds none.
bool is_near_closed_side(const VolumeGeometry& geometry, const VoxelBox& box, const VoxelBox& object,
                         const BoxSides& open);

}  // namespace simplexseg
