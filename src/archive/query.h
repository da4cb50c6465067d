// SPDX-License-Identifier: Apache-2.0
// Queries to archives and their results.
#pragma once
#include <string>
#include <vector>

namespace simplexseg {

/// Search for studies; an empty text matches all studies. Wildcards: "*" for any characters, "?" for one character.
struct ArchiveQuery {
  std::string patient_name;  ///< DICOM form, for example "DOE^JANE"; without wildcards, part of the name
  std::string patient_id;    ///< complete ID, or a pattern with wildcards
  std::string date;          ///< study date "2024-05-31", or range "2024-01-01..2024-12-31"; one end may be empty
  std::string modality;      ///< modality of a series in the study, for example "CT"
  std::string description;   ///< study description; without wildcards, part of it
  std::string study;         ///< UID of the study
  int max_studies = 200;     ///< largest number of studies, 1 to 10000
};

/// Converts a date or range to DICOM form, for example "20240101-20241231"; an empty text stays empty. Throws Error for
/// another form, an impossible date, or a range that ends before it begins.
std::string dicom_date_range(const std::string& date);

/// Study in an archive. Texts are UTF-8 on one line and may be empty.
struct ArchiveStudy {
  std::string uid;
  std::string patient_name;  ///< for display, for example "Doe, Jane"
  std::string patient_id;
  std::string date;  ///< study date, for example "2024-05-31"
  std::string description;
  std::vector<std::string> modalities;
  int series = -1;     ///< number of series; below 0: not reported
  int instances = -1;  ///< number of instances; below 0: not reported

  friend bool operator==(const ArchiveStudy&, const ArchiveStudy&) = default;
};

/// Series of a study.
struct ArchiveSeries {
  std::string study;  ///< UID of the study
  std::string uid;
  int number = 0;
  std::string modality;
  std::string description;
  int instances = -1;  ///< number of instances; below 0: not reported

  friend bool operator==(const ArchiveSeries&, const ArchiveSeries&) = default;
};

/// Result of a search.
struct FoundStudies {
  std::vector<ArchiveStudy> studies;  ///< latest first
  bool more = false;                  ///< more studies match than `max_studies`
};

/// Whether a text is a UID (PS3.5, 9): 1 to 64 digits and periods, each period between digits. Other texts must not be
/// used as UIDs in paths or URLs.
bool is_dicom_uid(const std::string& text);

}  // namespace simplexseg
