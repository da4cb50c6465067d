// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "core/volume.h"
#include "gui/slice_geometry.h"

namespace simplexseg {

/// Fills one intensity for each texel of `grid`, row by row: the voxels themselves where the grid meets voxel centres,
/// trilinear between them. NaN outside the volume. Any direction matrix; the voxels are read in their own type.
void sample_slice(const Volume& volume, const SliceGrid& grid, std::vector<float>& intensities);

/// A slice as the views draw it.
struct SliceImage {
  SliceGrid grid;
  std::vector<float> intensities;
  std::uint64_t stamp = 0;  ///< changes when the picture does
};

/// The three slices through the crosshair; each is sampled again only when its plane or the volume has changed.
class SliceImages {
 public:
  void set_volume(const Volume& volume);
  const SliceImage& image(Orientation orientation, const Eigen::Vector3d& through_mm);

 private:
  Volume volume_;
  SliceImage images_[3];
  double position_mm_[3];
  std::uint64_t next_stamp_ = 1;
};

}  // namespace simplexseg
