// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

namespace simplexseg {

/// What a DICOM file says of the patient and the study that it belongs to; UTF-8, each may be empty.
struct DicomTexts {
  std::string patient;     ///< "Doe, Jane"
  std::string patient_id;  ///< of the hospital
  std::string study;       ///< description
  std::string date;        ///< of the study, "2024-05-31"
  std::string series;      ///< description
  std::string modality;    ///< "CT"
};

/// Reads the header; all empty when the file cannot be read.
DicomTexts read_dicom_texts(const std::filesystem::path& file);

/// The first group of a person's name, "Doe^Jane^^Dr" -> "Doe, Jane, Dr".
std::string name_in_words(const std::string& text);
/// "20240531" -> "2024-05-31"; what is no date stays as it is.
std::string date_in_words(const std::string& text);

/// Text in a coding of DICOM's (Specific Character Set, PS3.3 C.12.1.1.2) as UTF-8; what has no letter there becomes
/// "?". Of several codings in one text (ISO 2022) those that iconv takes together are turned.
std::string utf8_of(const std::string& text, const std::string& character_set);

}  // namespace simplexseg
