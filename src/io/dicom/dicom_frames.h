// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "io/source/dicom_slice.h"

namespace gdcm {
class DataSet;
}

namespace simplexseg {

/// Returns the frames of an image, each with its own position, spacing, rescaling and traits (DicomSlice::traits).
/// `whole`: header that all frames share. Sources are the functional groups (PS3.3 C.7.6.16), the offsets of a dose
/// grid (C.8.8.3) or the vectors of nuclear medicine (C.8.4.8). Without any of these, the frames are time points, or
/// slices in file order with a warning.
std::vector<DicomSlice> frames_of(const gdcm::DataSet& data, const DicomSlice& whole);

/// Copies position, orientation and spacing to `slice`, as far as the data set has these attributes.
void read_image_plane(const gdcm::DataSet& data, DicomSlice& slice);

}  // namespace simplexseg
