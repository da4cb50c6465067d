// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "io/source/dicom_slice.h"

namespace simplexseg {

/// Contents of one file.
struct DicomFileScan {
  /// One slice for each frame in file order, or a single slice when the pixels are unreadable (DicomSlice::unreadable);
  /// none when the file is not DICOM or contains no image.
  std::vector<DicomSlice> slices;
  std::string failure;  ///< reason why the header cannot be read; empty when it can
};

/// Reads the headers of files. Calls `report` before each file with the number of those done.
std::vector<DicomFileScan> scan_dicom_files(const std::vector<std::filesystem::path>& files,
                                            const std::function<void(std::size_t)>& report);

/// Reads the header of one file. Throws std::runtime_error when it cannot be read.
std::vector<DicomSlice> scan_dicom(const std::filesystem::path& path);

/// Returns the name of the SOP class of a DICOM file, e.g. "RT Structure Set Storage"; empty when the class is unknown
/// or the file is damaged or not DICOM.
std::string sop_class_name(const std::filesystem::path& path);

/// Returns the quoted file name for messages, with the frame number if the file has several frames.
std::string name_of(const DicomSlice& slice);

/// Joins at most `max_names` names for messages and counts the others: "'a', 'b' and 3 more".
std::string list_of(const std::vector<std::string>& names, std::size_t max_names = 12);

}  // namespace simplexseg
