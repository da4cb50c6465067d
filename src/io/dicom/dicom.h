// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/source/volume_source.h"

namespace simplexseg {

/// Opens volume number `volume` (from 1) of one DICOM file. A single-frame file is a volume of one slice. Throws Error
/// when the file is unreadable or contains no image, and like open_dicom_slices().
VolumeSource open_dicom_file(const std::filesystem::path& path, int volume = 1);
/// Opens volume number `volume` (from 1) of the slices of one series. `format` is the value of VolumeInfo::format,
/// `series_name` the name of the series in messages. Throws Error when a slice is unreadable, when the slices form no
/// volume (split_volumes(), stack()) or when the volume does not exist.
VolumeSource open_dicom_slices(std::vector<DicomSlice> slices, const std::string& format,
                               const std::string& series_name, int volume);
/// Returns true when the file has the DICOM preamble (PS3.10, 7.1). Some DICOM files have none.
bool has_dicom_preamble(const std::filesystem::path& path);

}  // namespace simplexseg
