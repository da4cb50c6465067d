// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/volume_source.h"

namespace simplexseg {

/// One DICOM file; a classic single slice gives a volume of one slice.
VolumeSource open_dicom_file(const std::filesystem::path& path);
/// The largest DICOM series of a folder.
VolumeSource open_dicom_series(const std::filesystem::path& folder);
/// True when the file has the preamble of DICOM. One without it can be DICOM all the same.
bool looks_like_dicom(const std::filesystem::path& path);

}  // namespace simplexseg
