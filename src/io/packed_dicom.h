// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/volume_source.h"

namespace simplexseg {

/// Whether the file is a DICOM file that is packed by gzip.
bool looks_like_packed_dicom(const std::filesystem::path& path);

/// Opens one by a copy that is unpacked, in a temporary folder that goes with the source. Throws Error as
/// open_dicom_file() does, and when it is damaged or there is no room for the copy.
VolumeSource open_packed_dicom(const std::filesystem::path& path, int volume);

}  // namespace simplexseg
