// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "io/source/dicom_slice.h"
#include "io/source/volume_source.h"

namespace simplexseg {

/// Returns true for slices of a DICOM segmentation (PS3.3 C.8.20).
bool is_segmentation(const DicomSlice& slice);

/// Opens the frames of a segmentation as one label volume: a voxel contains the number of its segment, or 0. Slices
/// without a frame are 0, and the highest number is used where segments overlap. A fractional segment contains the
/// voxels that it fills at least by half. Throws Error like require_one_stack() and stack(), and when a frame has no
/// segment number.
VolumeSource open_segments(std::vector<DicomSlice> slices, const std::string& series_name);

}  // namespace simplexseg
