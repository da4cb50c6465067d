// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

namespace simplexseg {

/// What a DICOM file is, and to what it belongs: UIDs.
struct DicomIdentity {
  std::string sop_class, sop_instance, study, series;
  std::string transfer_syntax;  ///< how it is coded
};

/// Reads the header, and holds what it claims of the pixels against the size of the file. Throws Error when it is no
/// DICOM file, damaged or cut short, or does not say its class and instance.
DicomIdentity read_dicom_identity(const std::filesystem::path& path);

}  // namespace simplexseg
