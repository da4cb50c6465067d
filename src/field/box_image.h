// SPDX-License-Identifier: Apache-2.0
// A box of a volume as the evidence field sees it.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "field/box_grid.h"
#include "field/run_jobs.h"
#include "image/cell_grid.h"
#include "image/distance_map.h"
#include "image/volume.h"

namespace simplexseg {

/// Gaussian, separable, cut at three deviations, the border's value going on beyond it; `sigma` in voxels of each axis,
/// an axis with less than 0.2 is left alone.
void smooth(std::vector<float>& values, const BoxGrid& grid, const std::array<double, 3>& sigma, const RunJobs& run);

/// The same by a deviation in voxels of the least spacing.
void smooth_by_least_spacing(std::vector<float>& values, const BoxGrid& grid, const std::array<double, 3>& spacing_mm,
                             double voxels, const RunJobs& run);

struct BoxImage {
  BoxGrid grid;
  std::vector<float> value;          ///< 1st percentile of the box 0, 99th 1, clamped
  std::vector<std::uint8_t> finite;  ///< 0 where the volume is not; value is 0 there
};
/// Image of a box of cells. The intensity of a cell is the mean of its finite voxels, weighted by their part in the
/// cell; the cell is finite if they are at least half of it.
BoxImage cut_out(const Volume& volume, const CellSize& cell, const VoxelBox& box, const RunJobs& run);

}  // namespace simplexseg
