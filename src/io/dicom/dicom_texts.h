// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

namespace simplexseg {

/// Patient and study attributes of a DICOM file in UTF-8 for display; empty when missing.
struct DicomTexts {
  std::string patient;     ///< patient name, e.g. "Doe, Jane"
  std::string patient_id;  ///< patient ID
  std::string study;       ///< study description
  std::string date;        ///< study date, e.g. "2024-05-31"
  std::string series;      ///< series description
  std::string modality;    ///< modality, e.g. "CT"
};

/// Reads the attributes from the header; all texts are empty when the file cannot be read.
DicomTexts read_dicom_texts(const std::filesystem::path& file);

/// Converts the first component group of a person name for display: "Doe^Jane^^Dr" -> "Doe, Jane, Dr".
std::string display_name(const std::string& text);
/// Converts a date for display: "20240531" -> "2024-05-31". A text that does not start with eight digits is returned
/// unchanged.
std::string display_date(const std::string& text);

/// Returns true for valid UTF-8, such as ASCII.
bool is_utf8(const std::string& text);
/// Returns true for a Specific Character Set (PS3.3 C.12.1.1.2) other than the default (ASCII) that as_utf8() converts.
bool is_known_character_set(const std::string& character_set);
/// Converts a text from a DICOM Specific Character Set to UTF-8; invalid bytes become "?". Texts with several character
/// sets (ISO 2022) are converted as far as one iconv encoding covers them. A text without a known character set is
/// UTF-8 if it is valid as such, otherwise Windows-1252, which contains ISO 8859-1.
std::string as_utf8(const std::string& text, const std::string& character_set);
/// Returns the text of as_utf8() on one line, see one_line().
std::string utf8_of(const std::string& text, const std::string& character_set);

}  // namespace simplexseg
