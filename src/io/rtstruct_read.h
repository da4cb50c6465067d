// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/segment_names.h"

namespace simplexseg {

/// Contours that became labels.
struct StructureLabels {
  Volume labels;                      ///< on the grid that was asked for; a region's number is its label
  std::vector<SegmentName> segments;  ///< one for each region with contours
  std::vector<std::string> warnings;  ///< contours that are no areas or lie beyond the grid, regions that overlap
};

/// Whether the file is a DICOM RT structure set.
bool is_structure_set(const std::filesystem::path& path);

/// The regions of an RT structure set as labels: voxels of `grid` whose centre lies within a region's closed contours
/// of their slice, an odd number of them (so that contours within others are holes, and keyholes are too). Of regions
/// that overlap the first keeps the voxel. Throws Error when the file is damaged or none, a contour lies across the
/// grid's slices, or no contour lies within the grid.
StructureLabels read_structure_set(const std::filesystem::path& path, const VolumeGeometry& grid);

}  // namespace simplexseg
