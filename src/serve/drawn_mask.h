// SPDX-License-Identifier: Apache-2.0
// Scribbles and lassos that a client draws as voxels, converted to strokes and contours.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "image/mask.h"

namespace simplexseg {

/// Largest number of strokes or contours of one drawn mask.
inline constexpr int kMaxDrawnParts = 64;

/// Paths in mm along the middle of a scribble, one for each branch, in the slices of the axis along which the mask is
/// thinnest. Throws Error for an empty mask and one of more than kMaxDrawnParts parts.
std::vector<std::vector<Eigen::Vector3d>> paths_of_scribble(const Mask& mask);

/// Closed contour in a slice.
struct DrawnContour {
  std::vector<Eigen::Vector3d> contour_mm;
  Eigen::Vector3d normal;  ///< unit normal of the slice
};
/// Contours of the areas that a lasso encloses, in the slices of the axis along which the mask is thinnest. The mask is
/// filled, or a closed line, whose middle is then the contour. Areas below 9 voxels are omitted unless all are. Throws
/// Error for an empty mask and one of more than kMaxDrawnParts areas.
std::vector<DrawnContour> contours_of_lasso(const Mask& mask);

}  // namespace simplexseg
