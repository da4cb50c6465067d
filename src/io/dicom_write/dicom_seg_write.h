// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/dicom_write/dicom_source.h"
#include "io/source/segment_names.h"

namespace simplexseg {

/// Writes integer labels on the grid of the image `source` as binary DICOM segmentation (PS3.3 A.51). There is a
/// segment for each of `names` and for each other label in the volume, numbered from 1 in the order of the label
/// values. Each segment has a frame for every slice in which it has voxels; slices without any voxel get a frame of the
/// first segment, so that readers obtain the whole grid. A segment gets its codes, or those of tissue, and its name
/// by dicom_names(). Returns a message for the user when segment numbers differ from label values, otherwise an
/// empty text. Throws Error when there is neither a labelled voxel nor a name, when a label is below 1, when the grids
/// differ, when there are more than 65535 segments or 4 GiB of pixels, or when the file cannot be written.
std::string write_dicom_segmentation(const std::filesystem::path& path, const Volume& labels,
                                     const std::vector<SegmentName>& names, DicomSource source);

}  // namespace simplexseg
