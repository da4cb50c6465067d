// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "io/source/dicom_slice.h"

namespace gdcm {
class DataSet;
}

namespace simplexseg {

/// Returns the frames of an image, each with its own position, spacing, rescaling and traits (DicomSlice::traits).
/// `whole` contains the attributes that all frames share. Positions come from the functional groups (PS3.3 C.7.6.16),
/// the offsets of a dose grid (C.8.8.3) or the vectors of nuclear medicine (C.8.4.8). Without any of these, several
/// frames are time points at one position, or slices in file order with a warning.
std::vector<DicomSlice> frames_of(const gdcm::DataSet& data, const DicomSlice& whole);

/// Copies position, orientation, pixel spacing, slice distance and thickness to `slice`. Missing or invalid attributes
/// leave `slice` unchanged.
void read_image_plane(const gdcm::DataSet& data, DicomSlice& slice);

}  // namespace simplexseg
