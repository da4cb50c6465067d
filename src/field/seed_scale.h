// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>

#include "image/volume.h"

namespace simplexseg {

/// Scale of an object, estimated from a ball inside it.
struct SeedScale {
  double scale_mm;  ///< approximate radius of the largest ball in the object, mm
  bool has_edges;   ///< whether the image has clear edges within three radii of the ball
};
/// Object scale, mm: 20% quantile over rays from the centre of the ball of the distance to the first sample that
/// differs from the interior of the ball by several standard deviations. The radius of the ball if two such limits give
/// different distances or the ball is about as large; at most twice that radius. Source: docs/mathematics.md 8.1.
SeedScale seed_scale(const Volume& volume, const Eigen::Vector3d& centre_mm, double radius_mm);

}  // namespace simplexseg
