// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "io/dicom_slice.h"

namespace gdcm {
class DataSet;
}

namespace simplexseg {

/// The frames of an image whose common header is `whole`, each with its own place, spacing, rescaling and traits, from
/// what says so: functional groups (PS3.3 C.7.6.16), a dose grid's offsets (C.8.8.3), vectors of nuclear medicine
/// (C.8.4.8). Where nothing does, they are pictures in time or, as an assumption that is said, slices in their order.
std::vector<DicomSlice> frames_of(const gdcm::DataSet& data, const DicomSlice& whole);

/// Position, orientation and spacing as plain attributes of a data set, whichever it has.
void take_place(const gdcm::DataSet& data, DicomSlice& slice);

}  // namespace simplexseg
