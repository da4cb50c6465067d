// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/source/segment_names.h"

namespace simplexseg {

/// Regions converted to labels.
struct StructureLabels {
  Volume labels;                      ///< UInt16, on the requested grid; a label is the number of its region
  std::vector<SegmentName> segments;  ///< one for each region with contours in the grid
  std::vector<std::string> warnings;  ///< skipped contours and overlapping regions, one line each
};

/// Returns true for a DICOM RT structure set with preamble; false for unreadable files.
bool is_structure_set(const std::filesystem::path& path);

/// Region of an RT structure set.
struct StructureRegion {
  SegmentName name;                           ///< number, name and colour
  std::vector<std::vector<double>> contours;  ///< closed contours: x, y, z of each point, LPS, mm
  int other_contours = 0;                     ///< number of contours of other types, e.g. points and open lines
};

/// Returns all regions of an RT structure set, including those without contours. Throws Error when the file is damaged
/// or not a structure set.
std::vector<StructureRegion> read_structure_regions(const std::filesystem::path& path);

/// Rasterises regions on `grid` by the even-odd rule: a voxel belongs to a region when its centre is inside an odd
/// number of the region's contours in that slice, so inner contours and keyholes are holes. A voxel in several regions
/// gets the label of the first. `path` is the file name in messages. Throws Error when a contour crosses slices of the
/// grid, when no contour lies in the grid, or when the number of a region is not 1 to 65535.
StructureLabels rasterise_regions(std::span<const StructureRegion> regions, const VolumeGeometry& grid,
                                  const std::filesystem::path& path);

/// Reads a structure set and rasterises its regions. Throws Error like read_structure_regions() and
/// rasterise_regions().
StructureLabels read_structure_set(const std::filesystem::path& path, const VolumeGeometry& grid);

}  // namespace simplexseg
