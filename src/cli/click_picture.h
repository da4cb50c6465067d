// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "field/marks.h"
#include "image/mask.h"
#include "image/volume.h"
#include "io/picture/picture_io.h"

namespace simplexseg {

/// Draws three slices along the voxel axes, cropped to truth and result. They pass through the deepest voxel of the
/// largest error, or of the truth if there is no error. Outlines: truth green, result orange, field cyan (if there is
/// one). Circles: marks that a slice cuts or that lie within one voxel of it; inside blue, outside red, boundary white.
Picture draw_clicks(const Volume& image, const Mask& truth, const Mask& result, const Mask& field,
                    std::span<const Mark> marks);

}  // namespace simplexseg
