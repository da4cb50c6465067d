// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/source/volume_source.h"

namespace simplexseg {

/// Returns true for a gzip-compressed DICOM file with preamble. Throws Error when the file is missing, empty or cannot
/// be opened.
bool is_gzipped_dicom(const std::filesystem::path& path);

/// Decompresses the file into a temporary folder, which is deleted with the last copy of the returned source, and opens
/// volume number `volume` (from 1). Throws Error like open_dicom_file(), and when the compressed data is damaged or the
/// disk is full.
VolumeSource open_gzipped_dicom(const std::filesystem::path& path, int volume);

}  // namespace simplexseg
