// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "image/volume.h"

namespace simplexseg {

/// Usual CT window width and level of a body region, in Hounsfield units.
struct ContrastPreset {
  const char* title;
  double window, level;
};
std::span<const ContrastPreset> contrast_presets();

/// Intensity range for automatic contrast: from the 1st percentile of all voxels to the 99.5th percentile of the voxels
/// above the lowest value; for a CT, the soft-tissue window. `max` is above `min` even for a constant volume.
Volume::Range contrast_range(const Volume& volume);

}  // namespace simplexseg
