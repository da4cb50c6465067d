// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "io/dicom_source.h"
#include "io/picture_io.h"

namespace simplexseg {

/// Writes a picture of a view as a DICOM secondary capture (PS3.3 A.8.1) of the patient and study of the image
/// `source`, in a series of its own; `description` is that series'. Throws Error when the picture is empty, has a side
/// above 65535 pixels, or the file cannot be written.
void write_secondary_capture(const std::filesystem::path& path, const Picture& picture, const std::string& description,
                             DicomSource source);

}  // namespace simplexseg
