// SPDX-License-Identifier: Apache-2.0
// A box of voxels and a coarser grid of blocks of them.
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

/// Between which two blocks the middle of a voxel along an axis lies, and how far on the way.
struct BetweenBlocks {
  int low, high;
  float share;

  SIMPLEXSEG_HD BetweenBlocks(int voxel, int blocks, int width) {
    const float at = smaller(larger((static_cast<float>(voxel) + 0.5f) / static_cast<float>(width) - 0.5f, 0.0f),
                             static_cast<float>(blocks - 1));
    low = static_cast<int>(at);
    high = smaller(low + 1, blocks - 1);
    share = at - static_cast<float>(low);
  }
};

inline constexpr int kAlikeBlocks = 4;  ///< those that differ by no more than this need no look at the image

/// What a voxel that looks like `own` gets of eight blocks: `lines` where four rows of blocks begin, `share` what each
/// row weighs, `low` and `high` the two blocks of a row, `x` how far on the way between them.
SIMPLEXSEG_HD std::uint8_t mixed_of_blocks(const std::uint8_t* blocks, const float* looks, const int (&lines)[4],
                                           const float (&share)[4], int low, int high, float x, float own,
                                           float per_difference) {
  float sum = 0, weights = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int block = lines[corner / 2] + (corner % 2 ? high : low);
    const float d = (looks[block] - own) * per_difference;
    const float weight = share[corner / 2] * (corner % 2 ? x : 1 - x) / (1 + d * d);
    sum += weight * blocks[block];
    weights += weight;
  }
  return static_cast<std::uint8_t>(sum / weights + 0.5f);
}

struct VoxelBlocks {
  BoxGrid fine, coarse;
  std::array<int, 3> width{1, 1, 1};  ///< of a block, voxels; the last of a row may be narrower

  VoxelBlocks() = default;
  VoxelBlocks(const BoxGrid& of, const std::array<int, 3>& wide);

  /// The blocks as a grid of their own; `volume` is that of the volume, `first` the box's first voxel in it. A last
  /// block that is narrower counts as one that is not.
  VolumeGeometry geometry(const VolumeGeometry& volume, const std::array<int, 3>& first) const;
  /// Calls visit(block, voxel) for each voxel of the box, plane by plane of blocks side by side.
  template <class Visit>
  void visit(const RunJobs& run, const Visit& visit) const;
  /// Mean of each block's voxels.
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
