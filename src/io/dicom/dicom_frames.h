// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "io/source/dicom_slice.h"

namespace gdcm {
class DataSet;
}

namespace simplexseg {

/// Returns the frames of an image, each with its own position, spacing, rescaling and traits (DicomSlice::traits).
/// `whole` contains the attributes that all frames share. Positions come from the functional groups (PS3.3 C.7.6.16),
/// the offsets of a dose grid (C.8.8.3) or the vectors of nuclear medicine (C.8.4.8). Without any of these, several
/// frames are time points at one position, or slices in file order along the normal of the first, with a warning.
/// Throws InvalidElement for values that the position or the rescaling depends on.
std::vector<DicomSlice> frames_of(const gdcm::DataSet& data, const DicomSlice& whole);
/// Returns true when the values of a trait are numbers, which order the volumes of a series, e.g. for "echo time".
bool is_numeric_trait(const std::string& name);

/// Copies position, orientation, pixel spacing, slice distance and thickness to `slice`. Missing attributes leave
/// `slice` unchanged; so do axes that are not perpendicular and spacings of 0, which are added to slice.ignored.
/// Throws InvalidElement for other invalid values.
void read_image_plane(const gdcm::DataSet& data, DicomSlice& slice);
/// Copies slope and intercept, for a dose the dose grid scaling, to `slice`; a slope of 0 is added to slice.ignored.
/// Throws InvalidElement for invalid values.
void read_rescaling(const gdcm::DataSet& data, DicomSlice& slice);

}  // namespace simplexseg
