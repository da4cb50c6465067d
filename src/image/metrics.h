// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "image/mask.h"

namespace simplexseg {

/// Agreement of two masks on one grid. Boundary voxels have a 6-neighbour outside the mask or outside the image.
/// Distances are between centres of boundary voxels in mm, with the full direction matrix. The symmetric HD95 is the
/// larger of the two directed 95th percentiles (linear interpolation), the ASSD the mean of the two directed means. If
/// one mask is empty, distances are infinite and Dice is 0; if both are empty, distances are 0 and Dice is 1.
struct Agreement {
  double dice;
  double hd_mm, hd95_mm, assd_mm;
  double hd_directed_mm, hd95_directed_mm, asd_directed_mm;  ///< from the reference boundary to the test boundary
  double reference_mm3, test_mm3;
};
/// Computes all measures. Throws Error as require_same_grid().
Agreement compare(const Mask& reference, const Mask& test);
/// Throws Error if the two grids differ or a mask does not match the size of its grid.
void require_same_grid(const Mask& reference, const Mask& test);
/// Dice coefficient, without computing distances. Throws Error as require_same_grid().
double dice(const Mask& reference, const Mask& test);

}  // namespace simplexseg
