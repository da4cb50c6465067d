// SPDX-License-Identifier: Apache-2.0
// Blocks of the voxels of a box.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/vec3.h"
#include "field/box_grid.h"
#include "field/run_jobs.h"
#include "image/volume.h"

namespace simplexseg {

/// Linear interpolation between blocks at the centre of a voxel, along an axis.
struct BlockInterpolation {
  int low, high;
  float share;  ///< weight of `high`

  SIMPLEXSEG_HD BlockInterpolation(int voxel, int blocks, int width) {
    const float at = smaller(larger((static_cast<float>(voxel) + 0.5f) / static_cast<float>(width) - 0.5f, 0.0f),
                             static_cast<float>(blocks - 1));
    low = static_cast<int>(at);
    high = smaller(low + 1, blocks - 1);
    share = at - static_cast<float>(low);
  }
};

/// Largest difference of blocks that are interpolated without the image, 1/255.
inline constexpr int kSimilarBlocks = 4;

/// Mean of the eight blocks around a voxel with the intensity `own`, weighted by distance and intensity. `rows`: first
/// blocks of four rows, `row_weight`: their weights; `low`, `high`: indices in a row, `share`: weight of `high`.
SIMPLEXSEG_HD std::uint8_t bilateral_mean(const std::uint8_t* blocks, const float* image, const int (&rows)[4],
                                          const float (&row_weight)[4], int low, int high, float share, float own,
                                          float per_difference) {
  float sum = 0, weights = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int block = rows[corner / 2] + (corner % 2 ? high : low);
    const float d = (image[block] - own) * per_difference;
    const float weight = row_weight[corner / 2] * (corner % 2 ? share : 1 - share) / (1 + d * d);
    sum += weight * blocks[block];
    weights += weight;
  }
  return static_cast<std::uint8_t>(sum / weights + 0.5f);
}

struct VoxelBlocks {
  BoxGrid fine, coarse;
  std::array<int, 3> width{1, 1, 1};  ///< of a block, voxels; the last block along an axis may be narrower

  VoxelBlocks() = default;
  VoxelBlocks(const BoxGrid& voxels, const std::array<int, 3>& block_width);

  /// Grid of the blocks. `volume`: grid of the volume, `first`: first voxel of the box. The centre of a last block that
  /// is narrower is computed as if it were complete.
  VolumeGeometry geometry(const VolumeGeometry& volume, const std::array<int, 3>& first) const;
  /// Calls visit(block, voxel) for each voxel of the box, in parallel over planes of blocks.
  template <class Visit>
  void visit(const RunJobs& run, const Visit& visit) const;
  /// Means over the voxels of each block.
  std::vector<float> mean(std::span<const float> values, const RunJobs& run) const;
};

template <class Visit>
void VoxelBlocks::visit(const RunJobs& run, const Visit& visit) const {
  run(coarse.size[2], [&](int plane) {
    const int end = std::min((plane + 1) * width[2], fine.size[2]);
    for (int k = plane * width[2]; k < end; ++k)
      for (int j = 0; j < fine.size[1]; ++j) {
        const int voxel = (k * fine.size[1] + j) * fine.size[0],
                  block = (plane * coarse.size[1] + j / width[1]) * coarse.size[0];
        for (int i = 0, b = block, in = 0; i < fine.size[0]; ++i) {
          visit(b, voxel + i);
          if (++in == width[0]) in = 0, ++b;
        }
      }
  });
}

}  // namespace simplexseg
