// SPDX-License-Identifier: Apache-2.0
// Comparison of positions, relative to the spacing of the grid: grids of 8 um and of 100 mm follow the same rule.
#pragma once
#include <Eigen/Core>
#include <span>

#include "io/source/dicom_slice.h"

namespace simplexseg {

/// Returns the largest distance between two positions that count as one, mm: 1% of `spacing_mm`, or the rounding of
/// coordinates up to `coordinate_mm` in single precision if that is larger, but at most 10% of the spacing. The
/// rounding alone applies where the spacing is unknown (0).
double same_position_mm(double spacing_mm, double coordinate_mm);
/// Returns same_position_mm() for the slices of a series. The spacing is the smallest of their pixel spacings and
/// stated slice distances (else thicknesses); where none is stated, the mean distance of the positions along the
/// normal.
double same_position_mm(std::span<const DicomSlice> slices);

/// Returns the unit normal of a slice; requires its axes.
Eigen::Vector3d slice_normal(const DicomSlice& slice);

}  // namespace simplexseg
