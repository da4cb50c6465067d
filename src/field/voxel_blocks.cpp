// SPDX-License-Identifier: Apache-2.0
#include "field/voxel_blocks.h"

#include <algorithm>

namespace simplexseg {
VoxelBlocks::VoxelBlocks(const BoxGrid& voxels, const std::array<int, 3>& block_width)
    : fine(voxels), width(block_width) {
  for (int a = 0; a < 3; ++a) coarse.size[a] = (fine.size[a] + width[a] - 1) / width[a];
}

VolumeGeometry VoxelBlocks::geometry(const VolumeGeometry& volume, const std::array<int, 3>& first) const {
  VolumeGeometry blocks = volume;
  Eigen::Vector3d middle;
  for (int a = 0; a < 3; ++a) {
    blocks.size[a] = coarse.size[a];
    blocks.spacing_mm[a] *= width[a];
    middle[a] = first[a] + 0.5 * (width[a] - 1);
  }
  blocks.origin_mm = volume.world_from_index() * middle;
  return blocks;
}

std::vector<float> VoxelBlocks::mean(std::span<const float> values, const RunJobs& run) const {
  if (width == std::array{1, 1, 1}) return {values.begin(), values.end()};
  std::vector<float> mean(coarse.count()), count(coarse.count());
  visit(run, [sum = mean.data(), n = count.data(), from = values.data()](int block, int voxel) {
    sum[block] += from[voxel];
    n[block] += 1;
  });
  for_each_index(run, coarse.count(), [sum = mean.data(), n = count.data()](int b) { sum[b] /= n[b]; });
  return mean;
}

}  // namespace simplexseg
