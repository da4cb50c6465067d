// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

#include "image/volume.h"

namespace simplexseg {

/// Labels resampled onto another grid.
struct ResampledLabels {
  Volume labels;
  std::size_t labelled = 0;  ///< non-zero voxels of the input
  std::size_t outside = 0;   ///< labelled voxels whose centre lies outside the new grid
};

/// Resamples labels by nearest neighbour: each voxel of `grid` gets the label at its centre, 0 outside the input.
ResampledLabels resample_labels(const Volume& labels, const VolumeGeometry& grid);

}  // namespace simplexseg
