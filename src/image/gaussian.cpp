// SPDX-License-Identifier: Apache-2.0
#include "image/gaussian.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace simplexseg {
namespace {

/// Number of voxels on each side that the Gaussian reaches along an axis of a box.
int reach_of(int size, double deviation_voxels) {
  return static_cast<int>(std::min(std::ceil(3 * deviation_voxels), std::max(size - 1.0, 3.0)));
}

void smooth_along(std::vector<float>& values, const VoxelBox& box, int axis, double deviation_voxels) {
  const int reach = reach_of(box.size[axis], deviation_voxels);
  std::vector<float> weight(static_cast<std::size_t>(reach) + 1);
  float sum = 0;
  for (int r = 0; r <= reach; ++r) {
    const double at = r / deviation_voxels;
    sum += (r ? 2 : 1) * (weight[r] = std::exp(static_cast<float>(-0.5 * at * at)));
  }
  for (float& w : weight) w /= sum;
  const std::size_t stride = axis == 0   ? 1
                             : axis == 1 ? static_cast<std::size_t>(box.size[0])
                                         : static_cast<std::size_t>(box.size[0]) * box.size[1];
  const int length = box.size[axis];
  std::vector<float> line(static_cast<std::size_t>(length) + 2 * static_cast<std::size_t>(reach));
  const std::size_t lines = box.voxel_count() / static_cast<std::size_t>(length);
  for (std::size_t n = 0; n < lines; ++n) {
    float* const first = values.data() + n / stride * stride * static_cast<std::size_t>(length) + n % stride;
    for (int i = 0; i < length; ++i) line[i + reach] = first[i * stride];
    for (int i = 0; i < length; ++i) {
      float value = weight[0] * line[i + reach];
      for (int r = 1; r <= reach; ++r) value += weight[r] * (line[i + reach - r] + line[i + reach + r]);
      first[i * stride] = value;
    }
  }
}

}  // namespace

void smooth_gaussian(std::vector<float>& values, const VoxelBox& box, const std::array<double, 3>& deviation_voxels) {
  for (int axis = 0; axis < 3; ++axis)
    if (deviation_voxels[axis] > 0) smooth_along(values, box, axis, deviation_voxels[axis]);
}

GaussianOfOnes::GaussianOfOnes(const VoxelBox& box, const std::array<double, 3>& deviation_voxels)
    : size_(box.size), small_{{0, 0, 0}, box.size} {
  // In a larger box, more voxels in the middle are out of reach of both sides.
  for (int a = 0; a < 3; ++a)
    small_.size[a] = std::min(box.size[a], 2 * reach_of(box.size[a], std::max(deviation_voxels[a], 0.0)) + 1);
  values_.assign(small_.voxel_count(), 1.0f);
  smooth_gaussian(values_, small_, deviation_voxels);
}

}  // namespace simplexseg
