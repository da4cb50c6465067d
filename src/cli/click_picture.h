// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "evidence/marks.h"
#include "image/mask.h"
#include "image/volume.h"
#include "io/picture_io.h"

namespace simplexseg {

/// Three slices along the voxel axes through the deepest voxel of what is wrong most (the truth's where nothing is),
/// cut to what is around truth and result: the image, the truth's outline in green, the result's in orange, the field's
/// (where there is one besides) in cyan, and the marks that the slices cut, inside in blue, outside in red, boundary in
/// white.
Picture draw_clicks(const Volume& image, const Mask& truth, const Mask& result, const Mask& field,
                    std::span<const Mark> marks);

}  // namespace simplexseg
