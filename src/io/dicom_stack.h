// SPDX-License-Identifier: Apache-2.0
// What makes a volume of the slices of a DICOM series. `what` names the series in messages.
#pragma once
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/dicom_slice.h"

namespace simplexseg {

/// Throws Error unless all slices are of one size, one spacing and one orientation, and have a position.
void require_one_stack(const std::vector<DicomSlice>& slices, const std::string& what);

/// Orders the slices by their place along the normal and sets spacing, origin and direction. Missing and doubled slices
/// are all named in one Error.
void stack(std::vector<DicomSlice>& slices, VolumeGeometry& geometry, std::vector<std::string>& warnings,
           const std::string& what);

}  // namespace simplexseg
