// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <vector>

#include "image/distance_map.h"

namespace simplexseg {

/// Smooths the values of a box with a Gaussian of the given standard deviation along each axis, voxels; 0: not along
/// this axis. The Gaussian is truncated at three standard deviations or the size of the box; values beyond the box are
/// 0.
void smooth_gaussian(std::vector<float>& values, const VoxelBox& box, const std::array<double, 3>& deviation_voxels);

/// Result of smooth_gaussian() for a box of ones, with the same bits. It depends on the distances from the sides alone,
/// and only as far as the Gaussian reaches.
class GaussianOfOnes {
 public:
  GaussianOfOnes(const VoxelBox& box, const std::array<double, 3>& deviation_voxels);
  float operator()(int i, int j, int k) const { return values_[small_.offset(place(0, i), place(1, j), place(2, k))]; }

 private:
  /// Place in the small box with the same distances from both sides, as far as they matter.
  int place(int axis, int at) const {
    const int last = size_[axis] - 1, small_last = small_.size[axis] - 1;
    return at <= last / 2 ? std::min(at, small_last / 2) : small_last - std::min(last - at, small_last / 2);
  }

  std::array<int, 3> size_;
  VoxelBox small_;
  std::vector<float> values_;
};

}  // namespace simplexseg
