// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <vector>

#include "image/distance_map.h"

namespace simplexseg {

/// Smooths the values of a box with a Gaussian of the given standard deviation along each axis, voxels; 0: not along
/// this axis. The Gaussian is truncated at three standard deviations or the size of the box; values beyond the box are
/// 0.
void smooth_gaussian(std::vector<float>& values, const VoxelBox& box, const std::array<double, 3>& deviation_voxels);

}  // namespace simplexseg
