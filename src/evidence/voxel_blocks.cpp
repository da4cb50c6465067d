// SPDX-License-Identifier: Apache-2.0
#include "evidence/voxel_blocks.h"

#include <algorithm>

namespace simplexseg {
namespace {

constexpr int kAlike = 4;  // blocks that differ by no more than this need no look at the image

/// Between which two blocks the middles of voxels along an axis lie, and how far on the way.
struct Between {
  std::vector<int> low, high;
  std::vector<float> share;

  Between(int voxels, int blocks, int width) : low(voxels), high(voxels), share(voxels) {
    for (int i = 0; i < voxels; ++i) {
      const float at = std::clamp((static_cast<float>(i) + 0.5f) / static_cast<float>(width) - 0.5f, 0.0f,
                                  static_cast<float>(blocks - 1));
      low[i] = static_cast<int>(at);
      high[i] = std::min(low[i] + 1, blocks - 1);
      share[i] = at - static_cast<float>(low[i]);
    }
  }
};

}  // namespace

VoxelBlocks::VoxelBlocks(const BoxGrid& of, const std::array<int, 3>& wide) : fine(of), width(wide) {
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

void VoxelBlocks::interpolate(std::span<const std::uint8_t> blocks, const Guide& guide, std::span<std::uint8_t> voxels,
                              const RunJobs& run) const {
  if (width == std::array{1, 1, 1}) {
    std::copy(blocks.begin(), blocks.end(), voxels.begin());
    return;
  }
  const Between along_i(fine.size[0], coarse.size[0], width[0]), along_j(fine.size[1], coarse.size[1], width[1]),
      along_k(fine.size[2], coarse.size[2], width[2]);
  const float per_difference = 1 / guide.difference;
  run(fine.size[2], [&](int k) {
    std::vector<std::uint8_t> least(coarse.size[0]), most(coarse.size[0]);
    for (int j = 0; j < fine.size[1]; ++j) {
      const auto line = [&](int plane, int row) { return plane * coarse.plane() + row * coarse.row(); };
      const int lines[4]{line(along_k.low[k], along_j.low[j]), line(along_k.low[k], along_j.high[j]),
                         line(along_k.high[k], along_j.low[j]), line(along_k.high[k], along_j.high[j])};
      const float z = along_k.share[k], y = along_j.share[j];
      const float share[4]{(1 - z) * (1 - y), (1 - z) * y, z * (1 - y), z * y};
      for (int b = 0; b < coarse.size[0]; ++b) {
        const auto [low, high] =
            std::minmax({blocks[lines[0] + b], blocks[lines[1] + b], blocks[lines[2] + b], blocks[lines[3] + b]});
        least[b] = low, most[b] = high;
      }
      const int first = k * fine.plane() + j * fine.row();
      for (int i = 0; i < fine.size[0]; ++i) {
        const int low = along_i.low[i], high = along_i.high[i];
        const int bottom = std::min(least[low], least[high]), top = std::max(most[low], most[high]);
        if (top - bottom <= kAlike) {
          voxels[first + i] = static_cast<std::uint8_t>((bottom + top + 1) / 2);
          continue;
        }
        const float x = along_i.share[i], own = guide.voxels[first + i];
        float sum = 0, weights = 0;
        for (int corner = 0; corner < 8; ++corner) {
          const int block = lines[corner / 2] + (corner % 2 ? high : low);
          const float d = (guide.blocks[block] - own) * per_difference;
          const float weight = share[corner / 2] * (corner % 2 ? x : 1 - x) / (1 + d * d);
          sum += weight * blocks[block];
          weights += weight;
        }
        voxels[first + i] = static_cast<std::uint8_t>(sum / weights + 0.5f);
      }
    }
  });
}

}  // namespace simplexseg
