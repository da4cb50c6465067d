// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "image/volume.h"
#include "session/scene.h"

namespace simplexseg {

/// Facts that a report states beside the scene.
struct CaseReportInput {
  std::filesystem::path volume_path{};  ///< file or folder of the volume; empty if the scene has none
  std::string patient{}, series{};      ///< texts of a DICOM image; the patient is printed only if it is not empty
  std::string intensity_unit{};         ///< or ""
  bool low_is_bright = false;           ///< MONOCHROME1
};

/// Whether the file name is that of a report: .pdf.
bool is_case_report(const std::filesystem::path& path);

/// Writes a report of a case as PDF (A4): image with size, spacing and SHA-256 checksum (sha256_of()), program version
/// and commit, date; a table of the objects (volume, intensities, axes) and of the measurements; for each object three
/// slices with its outline; seeds and prompts with their positions. States that it is not for diagnostic use. Reads the
/// files of the volume for the checksum. Throws Error if one cannot be read, or the report cannot be written.
void write_case_report(const std::filesystem::path& path, const Scene& scene, const Volume& volume,
                       const CaseReportInput& input);

}  // namespace simplexseg
