// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "io/source/volume_source.h"

namespace simplexseg {

/// Opens volume number `volume` (from 1) of a series. If its slices form no volume, images that certainly do not
/// belong to it are omitted, with a first warning that lists them: unreadable images of known position, images
/// without position, of another orientation or size than most, and copies with equal values. `repaired`, unless null,
/// receives whether images are omitted. Throws the Error of open_dicom_slices() for the whole series when the other
/// images form no volume (missing slices, different images at one position), or are less than half of the series.
VolumeSource open_repaired(const std::vector<DicomSlice>& slices, const std::string& series_name, int volume,
                           bool* repaired = nullptr);

}  // namespace simplexseg
