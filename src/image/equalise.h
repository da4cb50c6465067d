// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "image/volume.h"

namespace simplexseg {

/// Volume with an equalised histogram: each value is replaced by the share of finite voxels with a smaller one, times
/// 65535, as UInt16, so that equal ranges of new values have about equally many voxels. Values that are not finite
/// count as the smallest. Shares are those of at most a million voxels at regular steps. Throws Error if there is too
/// little memory.
Volume equalised(const Volume& volume);

}  // namespace simplexseg
