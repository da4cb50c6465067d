// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/volume_source.h"

namespace simplexseg {

/// One DICOM file; a classic single slice gives a volume of one slice. Of several volumes number `volume`, from 1.
VolumeSource open_dicom_file(const std::filesystem::path& path, int volume = 1);
/// The largest DICOM series of a folder.
VolumeSource open_dicom_series(const std::filesystem::path& folder, int volume = 1);
/// The volume of slices that are known to be of one series; `what` names it in messages, `volume` tells which of
/// several, from 1. Throws Error where they do not make one: see split_volumes() and stack().
VolumeSource open_dicom_slices(std::vector<DicomSlice> slices, const std::string& format, const std::string& what,
                               int volume);
/// True when the file has the preamble of DICOM. One without it can be DICOM all the same.
bool looks_like_dicom(const std::filesystem::path& path);

}  // namespace simplexseg
