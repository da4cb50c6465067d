// SPDX-License-Identifier: Apache-2.0
// Assembly of DICOM slices into a volume. `series_name` is the name of the series in messages.
#pragma once
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/source/dicom_slice.h"

namespace simplexseg {

/// Throws Error unless all slices have a position and an orientation and agree in size, pixel spacing and orientation.
void require_one_stack(const std::vector<DicomSlice>& slices, const std::string& series_name);

/// Sorts the slices by position along the normal and sets slice spacing, origin and direction of `geometry`; a tilted
/// stack becomes a sheared grid. Adds deviations from even spacing or from the header to `warnings`. Throws one Error
/// that lists all missing, duplicate and unevenly spaced slices, and an Error when slices are shifted sideways by more
/// than half a pixel.
void stack(std::vector<DicomSlice>& slices, VolumeGeometry& geometry, std::vector<std::string>& warnings,
           const std::string& series_name);

}  // namespace simplexseg
