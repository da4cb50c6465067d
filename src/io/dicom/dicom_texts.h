// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

namespace simplexseg {

/// Patient and study attributes of a DICOM file as UTF-8; each can be empty.
struct DicomTexts {
  std::string patient;     ///< "Doe, Jane"
  std::string patient_id;  ///< patient ID
  std::string study;       ///< study description
  std::string date;        ///< study date, "2024-05-31"
  std::string series;      ///< series description
  std::string modality;    ///< "CT"
};

/// Reads the header; all texts are empty when the file cannot be read.
DicomTexts read_dicom_texts(const std::filesystem::path& file);

/// Converts the first component group of a person name for display: "Doe^Jane^^Dr" -> "Doe, Jane, Dr".
std::string display_name(const std::string& text);
/// Converts a date for display: "20240531" -> "2024-05-31"; other texts are returned unchanged.
std::string display_date(const std::string& text);

/// Converts text from a DICOM Specific Character Set (PS3.3 C.12.1.1.2) to UTF-8; invalid bytes become "?". Texts with
/// several character sets (ISO 2022) are converted as far as one iconv encoding covers them.
std::string utf8_of(const std::string& text, const std::string& character_set);

}  // namespace simplexseg
