// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/source/volume_source.h"

namespace simplexseg {

/// Returns true for a gzip-compressed DICOM file.
bool is_gzipped_dicom(const std::filesystem::path& path);

/// Decompresses the file into a temporary folder, which is deleted with the source, and opens it. Throws Error like
/// open_dicom_file(), and when the compressed data is damaged or the disk is full.
VolumeSource open_gzipped_dicom(const std::filesystem::path& path, int volume);

}  // namespace simplexseg
