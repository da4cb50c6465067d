// SPDX-License-Identifier: Apache-2.0
#include "evidence/voxel_blocks.h"

#include <algorithm>

namespace simplexseg {
namespace {

/// Of all voxels along an axis.
std::vector<BetweenBlocks> between(int voxels, int blocks, int width) {
  std::vector<BetweenBlocks> all;
  all.reserve(voxels);
  for (int i = 0; i < voxels; ++i) all.emplace_back(i, blocks, width);
  return all;
}

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
  const std::vector<BetweenBlocks> along_i = between(fine.size[0], coarse.size[0], width[0]),
                                   along_j = between(fine.size[1], coarse.size[1], width[1]),
                                   along_k = between(fine.size[2], coarse.size[2], width[2]);
  const float per_difference = 1 / guide.difference;
  run(fine.size[2], [&](int k) {
    std::vector<std::uint8_t> least(coarse.size[0]), most(coarse.size[0]);
    for (int j = 0; j < fine.size[1]; ++j) {
      const auto line = [&](int plane, int row) { return plane * coarse.plane() + row * coarse.row(); };
      const int lines[4]{line(along_k[k].low, along_j[j].low), line(along_k[k].low, along_j[j].high),
                         line(along_k[k].high, along_j[j].low), line(along_k[k].high, along_j[j].high)};
      const float z = along_k[k].share, y = along_j[j].share;
      const float share[4]{(1 - z) * (1 - y), (1 - z) * y, z * (1 - y), z * y};
      for (int b = 0; b < coarse.size[0]; ++b) {
        const auto [low, high] =
            std::minmax({blocks[lines[0] + b], blocks[lines[1] + b], blocks[lines[2] + b], blocks[lines[3] + b]});
        least[b] = low, most[b] = high;
      }
      const int first = k * fine.plane() + j * fine.row();
      for (int i = 0; i < fine.size[0]; ++i) {
        const int low = along_i[i].low, high = along_i[i].high;
        const int bottom = std::min(least[low], least[high]), top = std::max(most[low], most[high]);
        if (top - bottom <= kAlikeBlocks) {
          voxels[first + i] = static_cast<std::uint8_t>((bottom + top + 1) / 2);
          continue;
        }
        voxels[first + i] = mixed_of_blocks(blocks.data(), guide.blocks.data(), lines, share, low, high,
                                            along_i[i].share, guide.voxels[first + i], per_difference);
      }
    }
  });
}

}  // namespace simplexseg
