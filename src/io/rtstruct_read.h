// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <span>
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

/// A region of an RT structure set.
struct StructureRegion {
  SegmentName name;                           ///< its number, name and colour
  std::vector<std::vector<double>> contours;  ///< closed ones: x, y, z of one corner after the other, mm (LPS)
  int others = 0;                             ///< points and open lines
};

/// The regions of an RT structure set, those without contours among them. Throws Error when the file is damaged or
/// none.
std::vector<StructureRegion> read_structure_regions(const std::filesystem::path& path);

/// Regions as labels: voxels of `grid` whose centre lies within a region's closed contours of their slice, an odd
/// number of them (so that contours within others are holes, and keyholes are too). Of regions that overlap the first
/// keeps the voxel. `path`: the file, for messages. Throws Error when a contour lies across the grid's slices, or no
/// contour lies within the grid.
StructureLabels paint_regions(std::span<const StructureRegion> regions, const VolumeGeometry& grid,
                              const std::filesystem::path& path);

/// Both, one after the other.
StructureLabels read_structure_set(const std::filesystem::path& path, const VolumeGeometry& grid);

}  // namespace simplexseg
