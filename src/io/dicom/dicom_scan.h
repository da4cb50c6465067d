// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "io/source/dicom_slice.h"

namespace simplexseg {

/// Reads the header and returns one slice for each frame in file order, or a single slice when the pixels are
/// unreadable (DicomSlice::unreadable). Returns no slices when the file is not DICOM or contains no image. Throws
/// std::exception when the file is damaged or its transfer syntax is not supported.
std::vector<DicomSlice> scan_dicom(const std::filesystem::path& path);

/// Returns the name of the SOP class of a DICOM file, e.g. "RT Structure Set Storage"; empty when the class is unknown
/// or the file is damaged or not DICOM.
std::string sop_class_name(const std::filesystem::path& path);

/// Returns the quoted file name for messages, with the frame number if the file has several frames.
std::string name_of(const DicomSlice& slice);

/// Joins at most `max_names` names for messages and counts the others: "'a', 'b' and 3 more".
std::string list_of(const std::vector<std::string>& names, std::size_t max_names = 12);

}  // namespace simplexseg
