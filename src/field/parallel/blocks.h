// SPDX-License-Identifier: Apache-2.0
// Kernels between the voxels of a box and its blocks (field/voxel_blocks.h).
#pragma once
#include <array>
#include <cstdint>

#include "field/coarse_image.h"
#include "field/parallel/constraints.h"
#include "field/voxel_blocks.h"

namespace simplexseg {

/// Writes the constraint of a block and the mean of the previous field in it.
struct ConstraintOfBlock {
  BoxGrid fine, coarse;
  std::array<int, 3> width;
  PaintedBalls marks;  ///< on the grid of the blocks
  const Constraint* voxels;
  const std::uint8_t* previous;  ///< null without a previous field
  Constraint* constraints;
  std::uint8_t* mean;

  SIMPLEXSEG_HD void operator()(const CellAt& p) const {
    const int b = p.v;
    const int first[3]{p.i * width[0], p.j * width[1], p.k * width[2]};
    int end[3], all = 0, outside = 0, not_finite = 0, sum = 0, previous_count = 0;
    for (int a = 0; a < 3; ++a) end[a] = smaller(first[a] + width[a], fine.size[a]);
    Constraint side = Constraint::None;
    for (int k = first[2]; k < end[2]; ++k) {
      for (int j = first[1]; j < end[1]; ++j) {
        for (int i = first[0]; i < end[0]; ++i) {
          const int v = (k * fine.size[1] + j) * fine.size[0] + i;
          ++all;
          outside += voxels[v] == Constraint::Outside;
          not_finite += voxels[v] == Constraint::NotFinite;
          side = side_constraint(side, voxels[v]);
          if (!previous) continue;
          sum += previous[v];
          previous_count += previous[v] != 0;
        }
      }
    }
    constraints[b] = marks.applied_to(constraint_of_block(outside, not_finite, all, side), p);
    mean[b] = mean_of_previous(sum, previous_count);
  }
};

/// Interpolates the prior between blocks (ParallelPrior::interpolate()).
struct InterpolateBlocks {
  BoxGrid fine, coarse;
  std::array<int, 3> width;
  const std::uint8_t* blocks;
  const float *block_image, *cell_image;
  float per_difference;
  std::uint8_t* voxels;

  SIMPLEXSEG_HD void operator()(const CellAt& p) const {
    const int v = p.v;
    const BlockInterpolation x(p.i, coarse.size[0], width[0]), y(p.j, coarse.size[1], width[1]),
        z(p.k, coarse.size[2], width[2]);
    const int plane = coarse.plane(), row = coarse.row();
    const int rows[4]{z.low * plane + y.low * row, z.low * plane + y.high * row, z.high * plane + y.low * row,
                      z.high * plane + y.high * row};
    int lowest = 255, highest = 0;
    for (const int first : rows) {
      for (const int block : {first + x.low, first + x.high}) {
        lowest = smaller(blocks[block], lowest);
        highest = larger(blocks[block], highest);
      }
    }
    if (highest - lowest <= kSimilarBlocks) {
      voxels[v] = static_cast<std::uint8_t>((lowest + highest + 1) / 2);
      return;
    }
    const float weights[4]{(1 - z.share) * (1 - y.share), (1 - z.share) * y.share, z.share * (1 - y.share),
                           z.share * y.share};
    voxels[v] =
        bilateral_mean(blocks, block_image, rows, weights, x.low, x.high, x.share, cell_image[v], per_difference);
  }
};

/// Writes whether a voxel of a side of the box may belong to the object (is_open()).
struct OpenVoxel {
  BoxGrid fine, coarse;
  std::array<int, 3> width;
  const Constraint* constraints;
  const std::uint8_t* open_blocks;
  std::uint8_t* open;

  SIMPLEXSEG_HD void operator()(const CellAt& p) const {
    const int v = p.v;
    const int b = (p.k / width[2] * coarse.size[1] + p.j / width[1]) * coarse.size[0] + p.i / width[0];
    open[v] = constraints[v] == Constraint::FarBorder && open_blocks[b] != 0;
  }
};

}  // namespace simplexseg
