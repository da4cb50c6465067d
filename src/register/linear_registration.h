// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "io/registration/registration_requests.h"
#include "register/itk_image.h"
#include "register/progress_sender.h"

namespace simplexseg::in_register {

/// Share of the linear registration of the time of a registration to a displacement field.
inline constexpr double kLinearShare = 0.1;

struct LinearResult {
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();  ///< points of the fixed image to the moving image, mm
  double metric_before = 0, metric_after = 0;
  std::vector<RegistrationLevel> levels;
};

/// Rigid registration, and then an affine one unless order.kind is Rigid. Mutual information (Mattes 2003) of samples
/// at pseudo-random points is maximised by L-BFGS at several resolutions.
///
/// Coordinates are measured from the centre of each image in units of the fixed image's radius, so that rotations and
/// translations have comparable effects, as L-BFGS requires. Each metric is computed by one thread, because ITK adds
/// the derivatives of several threads in the order in which they end; threads compute different starts.
LinearResult register_linearly(const FloatImage* fixed, const FloatImage* moving, const RegistrationOrder& order,
                               ProgressSender& progress);

}  // namespace simplexseg::in_register
