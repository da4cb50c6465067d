// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <span>

#include "io/rtstruct_read.h"

namespace simplexseg {

/// A grid for regions of a structure set where there is no image: its slices are the planes of their contours, with one
/// more at either end. Within a slice voxels are a hundredth of the regions' extent, but neither longer than slices are
/// apart nor shorter than a quarter of that; longer where the grid would get too large for its memory. Where the
/// regions lie in a single plane, `all` regions of the file say how far planes are apart. Throws Error when there is no
/// closed contour, when contours lie in planes of different directions or at uneven distances, or when nothing says how
/// thick a slice is.
VolumeGeometry grid_of_regions(std::span<const StructureRegion> regions, std::span<const StructureRegion> all,
                               const std::filesystem::path& path);

}  // namespace simplexseg
