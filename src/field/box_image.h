// SPDX-License-Identifier: Apache-2.0
// Intensities of a box of cells.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "field/box_grid.h"
#include "field/run_jobs.h"
#include "image/cell_grid.h"
#include "image/distance_map.h"
#include "image/intensity_range.h"
#include "image/volume.h"

namespace simplexseg {

/// Smooths by a separable Gaussian, truncated at three standard deviations; values beyond the border repeat the
/// outermost one. `sigma`: standard deviation along each axis, cells; below 0.2 the axis is not smoothed.
void smooth(std::vector<float>& values, const BoxGrid& grid, const std::array<double, 3>& sigma, const RunJobs& run);

/// Smooths by a Gaussian with the same standard deviation in mm along all axes: `voxels` times the smallest spacing.
void smooth_by_least_spacing(std::vector<float>& values, const BoxGrid& grid, const std::array<double, 3>& spacing_mm,
                             double voxels, const RunJobs& run);

struct BoxImage {
  BoxGrid grid;
  std::vector<float> value;          ///< intensity
  std::vector<std::uint8_t> finite;  ///< 0 where the image is not finite; the intensity is 0 there
};
/// Image of a box of cells in the intensities of the volume. The intensity of a cell is the mean of its finite voxels,
/// weighted by the fraction of each that lies in the cell; the cell is finite if these are at least half of it.
BoxImage extract_intensities(const Volume& volume, const CellSize& cell, const VoxelBox& box, const RunJobs& run);
/// Sets the cells that are not finite to the mean of the others.
void fill_with_mean(BoxImage& image);
/// extract_intensities() scaled to 0 at the 1st percentile of the box and 1 at the 99th, clamped.
BoxImage extract_box(const Volume& volume, const CellSize& cell, const VoxelBox& box, const RunJobs& run);

/// 1 for the cells of a box whose intensity lies in a range, else 0. The intensity is that of
/// extract_intensities(), smoothed by smooth_by_least_spacing() with `spacing_mm` and `smoothing` (voxels). Cells that
/// are not finite are 0, and count in the smoothing as the value of the range nearest to 0.
std::vector<std::uint8_t> cells_in_range(const Volume& volume, const CellSize& cell, const VoxelBox& box,
                                         const IntensityRange& range, const std::array<double, 3>& spacing_mm,
                                         double smoothing, const RunJobs& run);

}  // namespace simplexseg
