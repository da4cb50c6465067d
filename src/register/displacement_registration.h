// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>

#include "io/registration/registration_requests.h"
#include "register/itk_image.h"
#include "register/progress_sender.h"

namespace simplexseg::in_register {

/// Finds a displacement field on a grid of the fixed image by symmetric diffeomorphic registration (SyN, Avants 2008)
/// with `metric`, so that point + field(point), mapped by `affine`, lies in the moving image. Thick slices are
/// interpolated to voxels of equal sides first, so that smoothing has the same reach along all axes. Adds it, its level
/// and the metric through both to `found`. `done`: share of the work that is complete.
void add_displacements(const FloatImage* fixed, const FloatImage* moving, FieldMetric metric,
                       const Eigen::Affine3d& affine, double done, ProgressSender& progress,
                       RegistrationResponse& found);

}  // namespace simplexseg::in_register
