// SPDX-License-Identifier: Apache-2.0
// Lassos of a scene: points with a closed contour (UserPoint::lasso_normal).
#pragma once
#include <Eigen/Core>
#include <span>

#include "session/scene.h"

namespace simplexseg {

class Volume;

/// Lasso without an id. Its strokes are not determined yet. `contour_mm`: at least one vertex.
UserPoint lasso_of(ItemId mesh, MarkKind kind, std::span<const Eigen::Vector3d> contour_mm,
                   const Eigen::Vector3d& normal);
/// Determines the strokes of a lasso at its present position; none without a volume. A lasso that continues the seed
/// (UserPoint::continues) is that from which its mesh starts. Throws Error unless it is of
/// inside or outside, has three to 10,000 finite vertices and a unit normal, and encloses a part of the volume.
void update_lasso(UserPoint& point, const Volume& volume);
/// Number of strokes that a lasso stands for; 0 for other points.
int stroke_count(const UserPoint& point);

}  // namespace simplexseg
