// SPDX-License-Identifier: Apache-2.0
// Names, colours and codes of segments in the header of a .seg.nrrd file, as written by 3D Slicer:
// https://slicer.readthedocs.io/en/latest/developer_guide/modules/segmentations.html
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/source/segment_names.h"

namespace simplexseg {

class NrrdHeader;
struct StoredVoxels;
struct VolumeInfo;
struct VolumeSource;

/// Whether the file name ends with ".seg.nrrd".
bool is_segment_name(const std::filesystem::path& path);

/// Segments described in a header; empty for a plain volume.
std::vector<SegmentName> segments_of(const NrrdHeader& header);

/// Opens the layers of a file whose segments overlap: volumes along the axes of components and time, each with other
/// segments. A segment has the number of its label value or, if a value occurs in several layers, its number in the
/// file from 1, with a warning. A voxel of several segments has the highest number; values that no segment has are
/// ignored, both with a warning. `info`: header with the number of layers in `frames` and `components`. Throws Error
/// for a layer that does not exist, layers that are interleaved within slices, and like open_stored().
VolumeSource open_layers(const VolumeInfo& info, const StoredVoxels& voxels, const NrrdHeader& header,
                         const std::filesystem::path& path);

/// Header lines for a label volume of integers. They describe one segment, with its bounding box, for each of `names`
/// and for each other label in the voxels.
std::string segment_fields(const Volume& labels, const std::vector<SegmentName>& names);

}  // namespace simplexseg
