// SPDX-License-Identifier: Apache-2.0
// Parsers for the DICOM JSON model (PS3.18, F). Attributes that do not have the form of the standard are ignored.
#pragma once
#include <set>
#include <string>
#include <vector>

#include "archive/archive.h"

namespace simplexseg {

// Each function omits entries without a UID and accepts an empty text as an empty list. Throws ArchiveFault for another
// text that is not a JSON list, or is nested too deeply.
std::vector<ArchiveStudy> studies_of_json(const ArchiveServer& server, const std::string& text);
std::vector<ArchiveSeries> series_of_json(const ArchiveServer& server, const std::string& text,
                                          const std::string& study);
std::set<std::string> instances_of_json(const ArchiveServer& server, const std::string& text);

/// Response of an archive to instances that were sent (PS3.18, 10.5.3).
struct StoreResponse {
  int rejected = 0;     ///< number of rejected instances
  std::string reason;   ///< failure reason of the first rejected instance, hexadecimal ("A700"); empty: unknown
  std::string warning;  ///< warning about the first stored instance, one line; empty: none
};
StoreResponse store_response_of_json(const std::string& text);

}  // namespace simplexseg
