// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

#include "image/volume.h"

namespace simplexseg {

/// Result of resampling labels onto another grid.
struct ResampledLabels {
  Volume labels;
  std::size_t labelled = 0;  ///< number of labelled voxels of the input: neither 0 nor NaN
  std::size_t outside = 0;   ///< number of labelled voxels whose centre lies outside the new grid
};

/// Resamples labels by nearest neighbour: each voxel of `grid` gets the input label at its centre, or 0 outside the
/// input.
ResampledLabels resample_labels(const Volume& labels, const VolumeGeometry& grid);

}  // namespace simplexseg
