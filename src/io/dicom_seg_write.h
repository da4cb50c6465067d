// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/dicom_source.h"
#include "io/segment_names.h"

namespace simplexseg {

/// Writes labels (integers) on the grid of the image `source` as a DICOM segmentation (PS3.3 A.51): binary, a segment
/// for each of `names` and each other label that the voxels hold, in the order of their values and numbered from 1, a
/// frame for each slice that a segment has a voxel in, and one for every other slice, so that readers get the whole
/// grid. Segments whose names say an organ have its code, others that of tissue. Returns a line for the user where
/// numbers are not the labels' values, else nothing. Throws Error when no voxel is labelled and nothing named, the grid
/// is another, or the file cannot be written.
std::string write_dicom_segmentation(const std::filesystem::path& path, const Volume& labels,
                                     const std::vector<SegmentName>& names, DicomSource source);

}  // namespace simplexseg
