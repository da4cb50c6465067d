// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "image/intensity_range.h"
#include "image/volume.h"

namespace simplexseg {

/// Range from the 1st to the 99th percentile of the voxels of a rectangle: those nearest to its points at distances of
/// half the smallest spacing or less. `corners_mm`: three consecutive corners of the rectangle. Throws Error if fewer
/// than nine finite voxels are found, or if all have the same intensity.
IntensityRange range_of_rectangle(const Volume& volume, const std::array<Eigen::Vector3d, 3>& corners_mm);

/// Numbers of voxels with intensities in equal intervals of a range.
struct IntensityHistogram {
  IntensityRange range;
  std::vector<std::size_t> counts;
  /// Interval of an intensity; those beyond the range belong to the first and the last one. There must be counts.
  std::size_t interval_of(double intensity) const;
};
/// Histogram of every n-th finite voxel of a volume, at most a million, between its 0.1th and 99.9th percentile; empty
/// counts without finite voxels.
IntensityHistogram histogram_of(const Volume& volume, int intervals);

}  // namespace simplexseg
