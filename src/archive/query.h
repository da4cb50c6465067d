// SPDX-License-Identifier: Apache-2.0
// What an archive is asked for, and what it says it has.
#pragma once
#include <string>
#include <vector>

namespace simplexseg {

/// What studies are searched by; empty: whatever it is. "*" and "?" stand for any characters and any one.
struct ArchiveQuery {
  std::string patient_name;  ///< as DICOM has it, "DOE^JANE"; without * or ? a part of it
  std::string patient_id;    ///< whole, unless it has * or ?
  std::string date;          ///< of the study: "2024-05-31", or a range "2024-01-01..2024-12-31" with either end open
  std::string modality;      ///< "CT"; a study that has a series of it
  std::string description;   ///< of the study; without * or ? a part of it
  std::string study;         ///< UID
  int most = 200;            ///< studies at most, 1 to 10000
};

/// A date or range as above, as DICOM matches it ("20240101-20241231"; "" for ""). Throws Error for anything else, 31
/// February and the like, or a range that ends before it begins.
std::string dicom_date_range(const std::string& date);

/// A study, as the archive describes it. Texts are UTF-8 of one line, and may be empty.
struct ArchiveStudy {
  std::string uid;
  std::string patient_name;  ///< "Doe, Jane"
  std::string patient_id;
  std::string date;         ///< "2024-05-31"
  std::string description;  ///< of the study
  std::vector<std::string> modalities;
  int series = -1;     ///< how many; below 0 where the archive does not say
  int instances = -1;  ///< in all series

  friend bool operator==(const ArchiveStudy&, const ArchiveStudy&) = default;
};

/// A series of a study.
struct ArchiveSeries {
  std::string study;  ///< UID
  std::string uid;
  int number = 0;
  std::string modality;
  std::string description;
  int instances = -1;  ///< below 0 where the archive does not say

  friend bool operator==(const ArchiveSeries&, const ArchiveSeries&) = default;
};

/// Studies that were found.
struct FoundStudies {
  std::vector<ArchiveStudy> studies;  ///< the latest first
  bool more = false;                  ///< the archive has more than were asked for
};

/// Whether a text can be a UID (PS3.5, 9): digits and dots, 64 at most. What is no UID names no file and goes into no
/// address.
bool is_dicom_uid(const std::string& text);

}  // namespace simplexseg
