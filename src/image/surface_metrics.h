// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>

#include "image/mask.h"

namespace simplexseg {

/// Agreement of the surfaces of two masks on one grid, weighted by area and therefore independent of the voxels' size
/// and orientation. In each cell between eight voxel centres the surface is that of marching cubes through the
/// midpoints of the edges; the outside of the image is background. Distances are between the centres of cells crossed
/// by the surfaces. If one mask is empty, distances are infinite and shares 0; if both are empty, distances are 0 and
/// shares 1. Source: Nikolov et al. 2021, Clinically Applicable Segmentation of Head and Neck Anatomy for Radiotherapy
/// (J Med Internet Res 23:e26151), whose reference is google-deepmind/surface-distance.
struct SurfaceAgreement {
  double tolerance_mm;
  double hd_mm;                              ///< Hausdorff distance, the largest of all distances
  double hd95_mm;                            ///< larger of the two directed 95th percentiles by area
  double assd_mm;                            ///< mean of the two directed means
  double asd_reference_mm, asd_test_mm;      ///< directed means: reference to test, test to reference
  double surface_dice;                       ///< share of both surfaces within the tolerance of the other
  double overlap_reference, overlap_test;    ///< share of each surface within the tolerance
  double area_reference_mm2, area_test_mm2;  ///< surface areas
};
/// Compares the surfaces of two masks. Throws Error as require_same_grid(), or if the tolerance is negative or not
/// finite.
SurfaceAgreement compare_surfaces(const Mask& reference, const Mask& test, double tolerance_mm);

/// Surface area (mm^2) in a cell for each set of inside corners: bit x + 2y + 4z is corner (x, y, z). In ambiguous
/// cases, diagonal inside corners of a face are separated; if more than four corners are inside, diagonal outside
/// corners are. Polygons that are not planar are triangulated such that their area in the unit cell is largest.
std::array<double, 256> surface_areas(const Eigen::Matrix3d& mm_from_index);

}  // namespace simplexseg
