// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>

#include "image/mask.h"

namespace simplexseg {

class LabelFile;

/// Reference object: voxels with this label, or all that are not 0, on the grid of the image. `image`, `path`: files of
/// the image and of the labels, for messages. Throws Error for another grid or a label without voxels.
Mask reference_mask(LabelFile& labels, const std::optional<double>& label, const VolumeGeometry& grid,
                    const std::string& path, const std::string& image);

}  // namespace simplexseg
