// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string_view>

#include "field/marks.h"
#include "field/run_jobs.h"
#include "image/cell_grid.h"
#include "image/intensity_range.h"

namespace simplexseg {

/// Effect of a range of intensities on a segmentation.
enum class RangeEffect : std::uint8_t {
  Limits,       ///< excludes a part of the image and keeps the seed; also without limits
  AllVoxels,    ///< contains the intensities of all voxels: no effect
  NoVoxel,      ///< contains the intensity of no voxel: only marks and paint are left
  WithoutSeed,  ///< excludes more than half of the seed
};

/// Effect of a range on the field of cells of a size, which starts from the ball `seed`. Voxels that are not finite do
/// not count. `smoothing` as in cells_in_range(), by which the part of the seed in the range is found.
RangeEffect effect_of(const IntensityRange& range, const Volume& volume, const CellSize& cell, const Mark& seed,
                      double smoothing, const RunJobs& run);

/// Name in files: "limits", "all_voxels", "no_voxel" or "without_seed".
std::string_view name_of(RangeEffect effect);
/// Effect of a name; Limits for others.
RangeEffect range_effect_of(std::string_view name);

}  // namespace simplexseg
