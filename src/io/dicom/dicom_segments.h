// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "io/source/dicom_slice.h"
#include "io/source/volume_source.h"

namespace simplexseg {

/// Returns true for slices of a DICOM segmentation (PS3.3 C.8.20).
bool is_segmentation(const DicomSlice& slice);

/// Opens the frames of a segmentation as one label volume. A voxel has the number of its segment, or 0 for none; slices
/// without a frame are 0. Overlapping segments use the highest number; fractional segments use a threshold of one half.
/// Throws Error like stack().
VolumeSource open_segments(std::vector<DicomSlice> slices, const std::string& series_name);

}  // namespace simplexseg
