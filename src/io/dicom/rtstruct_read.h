// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/source/segment_names.h"

namespace simplexseg {

/// Contours converted to labels.
struct StructureLabels {
  Volume labels;                      ///< on the requested grid; the label is the region's number
  std::vector<SegmentName> segments;  ///< one for each region with contours
  std::vector<std::string> warnings;  ///< skipped contours and overlapping regions, one line each
};

/// Returns true for a DICOM RT structure set.
bool is_structure_set(const std::filesystem::path& path);

/// Region of an RT structure set.
struct StructureRegion {
  SegmentName name;                           ///< number, name and colour
  std::vector<std::vector<double>> contours;  ///< closed contours: x, y, z of each point, mm, LPS
  int other_contours = 0;                     ///< number of points and open lines
};

/// Returns all regions of an RT structure set, including those without contours. Throws Error when the file is damaged
/// or not a structure set.
std::vector<StructureRegion> read_structure_regions(const std::filesystem::path& path);

/// Rasterises regions on `grid` by the even-odd rule: a voxel belongs to a region when its centre is inside an odd
/// number of the region's contours in that slice, so inner contours and keyholes are holes. Where regions overlap the
/// first region wins. `path` is the file name in messages. Throws Error when a contour crosses slices of the grid, or
/// no contour lies in the grid.
StructureLabels rasterise_regions(std::span<const StructureRegion> regions, const VolumeGeometry& grid,
                                  const std::filesystem::path& path);

/// Reads a structure set and rasterises its regions.
StructureLabels read_structure_set(const std::filesystem::path& path, const VolumeGeometry& grid);

}  // namespace simplexseg
