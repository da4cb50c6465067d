// SPDX-License-Identifier: Apache-2.0
// Names and colours of segments in the header of a .seg.nrrd, as 3D Slicer writes them.
// https://slicer.readthedocs.io/en/latest/developer_guide/modules/segmentations.html
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/segment_names.h"

namespace simplexseg {

class NrrdHeader;

/// Whether the file's name ends as those of segmentations do.
bool is_segment_name(const std::filesystem::path& path);

/// The segments that a header names; none where it is that of a plain volume.
std::vector<SegmentName> segments_of(const NrrdHeader& header);

/// The lines of the header for labels (integers): a segment for each of `names` and for each other label that the
/// voxels hold, with the box that it takes.
std::string segment_fields(const Volume& labels, const std::vector<SegmentName>& names);

}  // namespace simplexseg
