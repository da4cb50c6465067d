// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "image/mask.h"

namespace simplexseg {

/// Agreement of two masks on one grid. Boundary: voxels of the mask with a 6-neighbour outside it, the image border
/// counting as outside; distances between voxel centres in mm (full direction matrix). HD95 symmetric is the larger of
/// the two directed 95th percentiles (linear interpolation), ASSD the mean of the two directed means. With one mask
/// empty, distances are infinite and Dice is 0; with both empty, distances are 0 and Dice is 1.
struct Agreement {
  double dice;
  double hd_mm, hd95_mm, assd_mm;
  double hd_directed_mm, hd95_directed_mm, asd_directed_mm;  ///< reference boundary to test boundary
  double reference_mm3, test_mm3;
};
/// Throws Error when the two grids differ.
Agreement compare(const Mask& reference, const Mask& test);
/// Throws Error when the two grids differ, or a mask has not its grid's voxels.
void require_same_grid(const Mask& reference, const Mask& test);
/// The Dice coefficient alone: cheap.
double dice(const Mask& reference, const Mask& test);

}  // namespace simplexseg
