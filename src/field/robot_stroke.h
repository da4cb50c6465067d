// SPDX-License-Identifier: Apache-2.0
// Strokes of the robot user.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "field/box_prompt.h"
#include "field/robot_user.h"

namespace simplexseg {

/// Path in mm of the stroke of a user in the slice through the deepest voxel of an error that shows most of the error:
/// along the middle of the error, from one end to the other, with the noise of a hand. `stroke`: number of the stroke;
/// equal numbers have equal noise. Rule: docs/clicks.md. Throws Error if the grids differ.
std::vector<Eigen::Vector3d> stroke_in_error(const Mask& truth, const Mask& now, const WorstError& error, int stroke);

/// Lasso of a user in the slice of stroke_in_error(): around the object, if a part of it is missing there, or around
/// what is surplus, with the noise of a hand; `kind` is inside or outside accordingly. Nothing if fewer than 4 voxels
/// would lie in it. Rule: docs/clicks.md. Throws Error if the grids differ.
struct RobotLasso {
  MarkKind kind;
  std::vector<Eigen::Vector3d> contour_mm;
  Eigen::Vector3d normal;  ///< unit normal of the slice
};
std::optional<RobotLasso> lasso_at_error(const Mask& truth, const Mask& now, const WorstError& error, int lasso);

/// Corners, in order, of the rectangle that a user draws around an object in the slice through its deepest voxel that
/// shows most of it, with the noise of a hand. Rule: docs/clicks.md.
BoxCorners box_around_object(const Mask& object, const WorstError& deepest);

}  // namespace simplexseg
