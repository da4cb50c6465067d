// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

#include "image/volume.h"

namespace simplexseg {

/// Labels brought onto another grid.
struct ResampledLabels {
  Volume labels;
  std::size_t labelled = 0;  ///< voxels of the given labels that are not 0
  std::size_t outside = 0;   ///< of these, those whose centre lies outside of the grid
};

/// Each voxel of `grid` takes the value of the voxel of `labels` that its centre lies in, 0 where it lies in none.
ResampledLabels resample_labels(const Volume& labels, const VolumeGeometry& grid);

}  // namespace simplexseg
