// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>

#include "image/volume.h"

namespace simplexseg {

/// Scale of an object, estimated from a ball inside it.
struct SeedScale {
  double reach_mm;  ///< radius of about the largest ball that the object contains, mm
  bool has_wall;    ///< whether the image has clear edges within three radii of the ball
};
/// Estimates the scale by rays from the centre of the ball: the distance to the first place that differs from the inner
/// part of the ball by several of its standard deviations, the 20% quantile over the rays. It is the radius of the ball
/// if two such limits give different distances or the ball is about as large, and at most twice that radius. Users do
/// not draw the largest ball.
SeedScale seed_scale(const Volume& volume, const Eigen::Vector3d& centre_mm, double radius_mm);

}  // namespace simplexseg
