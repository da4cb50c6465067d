// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "image/volume.h"

namespace simplexseg {

/// Low and high intensity between which nearly all voxels that differ from the background lie; for a CT, soft tissue.
/// `max` is above `min`, also for a volume without any contrast.
Volume::Range contrast_range(const Volume& volume);

}  // namespace simplexseg
