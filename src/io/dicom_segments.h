// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "io/dicom_slice.h"
#include "io/volume_source.h"

namespace simplexseg {

/// Whether the slice is of a DICOM segmentation (PS3.3 C.8.20).
bool is_segmentation(const DicomSlice& slice);

/// The frames of segmentations as one volume of labels: a voxel's value is the number of its segment, 0 where there is
/// none. Places without a frame hold none; where segments overlap the highest number is taken; of fractional ones what
/// is at least half. Throws Error as a stack of slices does.
VolumeSource open_segments(std::vector<DicomSlice> slices, const std::string& what);

}  // namespace simplexseg
