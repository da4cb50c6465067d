// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "image/volume.h"

namespace simplexseg {

/// Window and level, in Hounsfield units, that radiologists look at a part of the body with in a CT.
struct ContrastPreset {
  const char* title;
  double window, level;
};
std::span<const ContrastPreset> contrast_presets();

/// Low and high intensity between which nearly all voxels that differ from the background lie; for a CT, soft tissue.
/// `max` is above `min`, also for a volume without any contrast.
Volume::Range contrast_range(const Volume& volume);

}  // namespace simplexseg
