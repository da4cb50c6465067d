// SPDX-License-Identifier: Apache-2.0
// Assembly of DICOM slices into a volume. `series_name` is the name of the series in messages.
#pragma once
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/source/dicom_slice.h"

namespace simplexseg {

/// Returns true when both slices have the same orientation, or none.
bool same_plane(const DicomSlice& a, const DicomSlice& b);
/// Returns true when both slices have the same size, number of channels and pixel spacing.
bool same_size(const DicomSlice& a, const DicomSlice& b);
/// Returns true when at least two slices, all with position and orientation, are evenly spaced along the normal of the
/// first, one for each position.
bool are_evenly_spaced(const std::vector<DicomSlice>& slices);

/// Throws Error unless all slices have a position and an orientation and agree in size, number of channels, pixel
/// spacing and orientation.
void require_one_stack(const std::vector<DicomSlice>& slices, const std::string& series_name);

/// Sorts the slices by position along the normal and sets slice spacing, origin and direction of `geometry`; a tilted
/// stack becomes a sheared grid. Adds deviations from even spacing or from the header to `warnings`. Throws one Error
/// that lists all missing, duplicate and unevenly spaced slices, and an Error when slices are shifted sideways by more
/// than half a pixel.
void stack(std::vector<DicomSlice>& slices, VolumeGeometry& geometry, std::vector<std::string>& warnings,
           const std::string& series_name);

}  // namespace simplexseg
