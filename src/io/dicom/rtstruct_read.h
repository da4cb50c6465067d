// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "io/source/segment_names.h"

namespace simplexseg {

/// Returns true for a DICOM RT structure set with preamble; false for unreadable files.
bool is_structure_set(const std::filesystem::path& path);

/// Region of an RT structure set.
struct StructureRegion {
  /// Number, name in UTF-8, and colour. The number is the ROI number of the file or, if that is no label (1 to 65535,
  /// so not 0), the smallest free one.
  SegmentName name;
  std::vector<std::vector<double>> contours;  ///< closed contours: x, y, z of each point, LPS, mm
  int other_contours = 0;                     ///< number of contours of other types, e.g. points and open lines
  std::string frame_of_reference;             ///< UID of the image's frame of reference; empty if the file states none
  double slab_mm = 0;                         ///< thickness that the file states for a contour; 0 if it states none
  std::vector<std::string> warnings;          ///< changed and repeated numbers, one line each
};

/// Returns all regions of an RT structure set, including those without contours. Throws Error when the file is damaged
/// or not a structure set.
std::vector<StructureRegion> read_structure_regions(const std::filesystem::path& path);

}  // namespace simplexseg
