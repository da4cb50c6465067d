// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "io/registration/registration_requests.h"
#include "register/itk_image.h"
#include "register/progress_sender.h"

namespace simplexseg::in_register {

/// Result of a filter of ITK. Throws Error for an image without foreground or a result that is too large.
FilterResponse filtered(const FloatImage* image, const FilterOrder& order, ProgressSender& progress);

}  // namespace simplexseg::in_register
