// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <span>

#include "image/volume.h"
#include "io/dicom/rtstruct_read.h"

namespace simplexseg {

/// Returns a grid on which regions of a structure set can be rasterised when its image is not available. The slices are
/// the evenly spaced planes of the contours, plus one slice at each end. The pixel size is a hundredth of the larger
/// in-plane extent of the regions, but at least a quarter of the slice distance and at most the slice distance; it is
/// larger when the grid would exceed 50 million voxels. For regions in a single plane, the slice distance is the stated
/// thickness of their contours or else comes from `all` regions of the file. Contours are of one plane within 1% of the
/// distance of the planes, see plane_tolerance(). `path` is the file name in messages. Throws Error when there is no
/// closed contour, when the planes are not parallel, not evenly spaced or too close to each other, or when the slice
/// distance is unknown.
VolumeGeometry grid_of_regions(std::span<const StructureRegion> regions, std::span<const StructureRegion> all,
                               const std::filesystem::path& path);

}  // namespace simplexseg
