// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "register/itk_image.h"
#include "register/progress_sender.h"

namespace simplexseg::in_register {

/// Image divided by its bias field, which N4 (Tustison 2010) estimates in the voxels above Otsu's threshold of an image
/// that is reduced by `shrink` along each axis. Throws Error if no voxel lies above the threshold.
FloatImage::Pointer without_bias_field(const FloatImage* image, int shrink, int levels, int iterations,
                                       ProgressSender& progress);

}  // namespace simplexseg::in_register
