// SPDX-License-Identifier: Apache-2.0
// Assembly of DICOM slices to a volume. `series_name` is the name of the series in messages.
#pragma once
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/source/dicom_slice.h"

namespace simplexseg {

/// Throws Error unless all slices have a position and the same size, pixel spacing and orientation.
void require_one_stack(const std::vector<DicomSlice>& slices, const std::string& series_name);

/// Sorts the slices by position along the normal and sets spacing, origin and direction of `geometry`. Throws one Error
/// that lists all missing, duplicate and unevenly spaced slices.
void stack(std::vector<DicomSlice>& slices, VolumeGeometry& geometry, std::vector<std::string>& warnings,
           const std::string& series_name);

}  // namespace simplexseg
