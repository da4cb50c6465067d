// SPDX-License-Identifier: Apache-2.0
// Names and colours of segments in the header of a .seg.nrrd file, as written by 3D Slicer:
// https://slicer.readthedocs.io/en/latest/developer_guide/modules/segmentations.html
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/source/segment_names.h"

namespace simplexseg {

class NrrdHeader;

/// Whether the file name ends with ".seg.nrrd".
bool is_segment_name(const std::filesystem::path& path);

/// Segments described in a header; empty for a plain volume.
std::vector<SegmentName> segments_of(const NrrdHeader& header);

/// Header lines for a label volume of integers. They describe one segment, with its bounding box, for each of `names`
/// and for each other label in the voxels.
std::string segment_fields(const Volume& labels, const std::vector<SegmentName>& names);

}  // namespace simplexseg
