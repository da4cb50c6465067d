// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "image/volume.h"

namespace simplexseg {

/// Intensity range for automatic contrast: from the 1st percentile of all voxels to the 99.5th percentile of the voxels
/// above the lowest value; for a CT, the soft-tissue window. `max` is above `min` even for a constant volume.
Volume::Range contrast_range(const Volume& volume);

}  // namespace simplexseg
