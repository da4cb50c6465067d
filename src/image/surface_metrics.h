// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>

#include "image/mask.h"

namespace simplexseg {

/// Agreement of the surfaces of two masks on one grid, each piece of them counting by its area, so that neither voxel
/// size nor direction weights the numbers. In each cell between eight voxel centres the surface is that of marching
/// cubes through the middles of the edges; what lies beyond the image is outside. A distance is that between the
/// middles of cells that a surface crosses. With one mask empty, distances are infinite and shares 0; with both empty,
/// distances are 0 and shares 1. Source: Nikolov et al. 2021, Clinically Applicable Segmentation of Head and Neck
/// Anatomy for Radiotherapy (J Med Internet Res 23:e26151), whose reference is google-deepmind/surface-distance.
struct SurfaceAgreement {
  double tolerance_mm;
  double hd_mm;    ///< the largest distance
  double hd95_mm;  ///< the larger of both directions' distances that 95% of the area does not exceed
  double assd_mm;  ///< mean of both directions' means
  double asd_reference_mm, asd_test_mm;      ///< from the reference's surface to the test's, and back
  double surface_dice;                       ///< share of both surfaces that lies within the tolerance of the other
  double overlap_reference, overlap_test;    ///< the same of each
  double area_reference_mm2, area_test_mm2;  ///< of the surfaces
};
/// Throws Error when the two grids differ, or for a tolerance that is not finite or below 0.
SurfaceAgreement compare_surfaces(const Mask& reference, const Mask& test, double tolerance_mm);

/// Area (mm2) of the surface in a cell, by which of its corners are inside: bit x + 2y + 4z is corner (x, y, z). Where
/// two ways of closing it exist, inside corners that only touch at a face's diagonal are apart (of more than four
/// inside corners, the outside ones), and a polygon that is not plane is cut into the triangles of the largest area.
std::array<double, 256> surface_areas(const Eigen::Matrix3d& mm_from_index);

}  // namespace simplexseg
