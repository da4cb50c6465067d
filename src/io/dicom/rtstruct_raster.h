// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/dicom/rtstruct_read.h"

namespace simplexseg {

/// Regions converted to labels.
struct StructureLabels {
  Volume labels;                      ///< UInt16, on the requested grid; a label is the number of its region
  std::vector<SegmentName> segments;  ///< one for each region with contours in the grid
  std::vector<std::string> warnings;  ///< skipped contours and overlapping regions, one line each
};

/// Rasterises regions on `grid`. A contour stands for the slab around its plane, as thick as the planes of its region
/// are apart (PS3.3 C.8.8.6), and the region is sampled at voxel centres: each slice of the grid has the contours of
/// the nearest plane whose slab contains the slice. The volume is therefore right for contours that are finer or
/// coarser than the slices; slices in a gap of more than 1.5 plane distances beyond the slabs stay empty, with a
/// warning. A region that contains no slice centre is drawn on the nearest slices. The plane distance is the median of
/// the region; for one or two planes also the stated thickness and the median of `all` regions of the set are used.
/// Within one plane the even-odd rule applies: a voxel belongs to the region when its centre is inside an odd number of
/// contours, so inner contours, keyholes and contours of type CLOSEDPLANAR_XOR are holes; equal contours count once. A
/// voxel in several regions gets the label of the first. `path` is the file name in messages. Throws Error when a
/// contour leaves the slab of its plane, when no contour lies in the grid, or when the number of a region is not 1 to
/// 65535.
StructureLabels rasterise_regions(std::span<const StructureRegion> regions, const VolumeGeometry& grid,
                                  const std::filesystem::path& path, std::span<const StructureRegion> all = {});

/// Reads a structure set and rasterises its regions. Throws Error like read_structure_regions() and
/// rasterise_regions().
StructureLabels read_structure_set(const std::filesystem::path& path, const VolumeGeometry& grid);

}  // namespace simplexseg
