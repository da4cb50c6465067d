// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>

#include "image/volume.h"

namespace simplexseg {

/// Radius (mm) of about the largest ball that an object holds, from a smaller one inside it: along rays out of its
/// centre, how far it is to the first place that differs from the inner part of the ball by several of its own
/// deviations, of the nearest fifth of the rays the farthest. Where it is not the same wall for two such limits, and
/// for a ball that is large enough, the ball's own radius; at most twice that. Users do not draw the largest ball, and
/// the field takes the scale of an object from it.
double seed_reach_mm(const Volume& volume, const Eigen::Vector3d& centre_mm, double radius_mm);

}  // namespace simplexseg
