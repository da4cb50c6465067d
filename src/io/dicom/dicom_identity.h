// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

namespace simplexseg {

/// UIDs of a DICOM file.
struct DicomIdentity {
  std::string sop_class, sop_instance, study, series;
  std::string transfer_syntax;  ///< UID of the encoding of the data set
};

/// Reads the UIDs and checks that the file is large enough for its pixels; study and series are empty when missing.
/// Throws Error when the file is not DICOM, is damaged or truncated, or has no SOP class or instance UID.
DicomIdentity read_dicom_identity(const std::filesystem::path& path);

}  // namespace simplexseg
