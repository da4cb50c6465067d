// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/source/volume_source.h"

namespace simplexseg {

/// Opens volume number `volume` (from 1) of one DICOM file. A single-frame file is a volume of one slice.
VolumeSource open_dicom_file(const std::filesystem::path& path, int volume = 1);
/// Opens the largest DICOM series of a folder.
VolumeSource open_dicom_series(const std::filesystem::path& folder, int volume = 1);
/// Opens volume number `volume` (from 1) of the slices of one series; `series_name` is the name of the series in
/// messages. Throws Error when the slices form no volume: see split_volumes() and stack().
VolumeSource open_dicom_slices(std::vector<DicomSlice> slices, const std::string& format,
                               const std::string& series_name, int volume);
/// Returns true when the file has the DICOM preamble. A DICOM file without preamble is possible.
bool has_dicom_preamble(const std::filesystem::path& path);

}  // namespace simplexseg
