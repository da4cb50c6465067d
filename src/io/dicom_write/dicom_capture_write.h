// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "io/dicom_write/dicom_source.h"
#include "io/picture/picture_io.h"

namespace simplexseg {

/// Writes a picture of a view as DICOM secondary capture (PS3.3 A.8.1) in a new series with the given description, for
/// the patient and study of the image `source`. Throws Error when a side of the picture is not 1 to 65535 pixels, or
/// the file cannot be written.
void write_secondary_capture(const std::filesystem::path& path, const Picture& picture, const std::string& description,
                             DicomSource source);

}  // namespace simplexseg
