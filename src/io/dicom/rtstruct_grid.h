// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <span>

#include "io/dicom/rtstruct_read.h"

namespace simplexseg {

/// Returns a grid for regions of a structure set without its image. Its slices are the planes of the contours, plus one
/// slice at each end. The pixel size is a hundredth of the regions' extent, between a quarter of the slice distance and
/// the slice distance; it is larger when the grid would exceed the memory limit. For regions in a single plane, the
/// slice distance comes from `all` regions of the file. Throws Error when there is no closed contour, when the planes
/// are not parallel or not evenly spaced, or when the slice distance is unknown.
VolumeGeometry grid_of_regions(std::span<const StructureRegion> regions, std::span<const StructureRegion> all,
                               const std::filesystem::path& path);

}  // namespace simplexseg
