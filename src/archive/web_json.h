// SPDX-License-Identifier: Apache-2.0
// Parsers for the DICOM JSON model (PS3.18, F). Attributes in another form than the standard's are ignored.
#pragma once
#include <set>
#include <string>
#include <vector>

#include "archive/archive.h"

namespace simplexseg {

// Each function throws ArchiveFault for a text that is not a JSON list or is nested too deeply. Entries without a UID
// are omitted.
std::vector<ArchiveStudy> studies_of_json(const ArchiveServer& server, const std::string& text);
std::vector<ArchiveSeries> series_of_json(const ArchiveServer& server, const std::string& text,
                                          const std::string& study);
std::set<std::string> instances_of_json(const ArchiveServer& server, const std::string& text);

/// Response of an archive to instances that were sent (PS3.18, 10.5.3).
struct StoreResponse {
  int rejected = 0;     ///< number of rejected instances
  std::string reason;   ///< reason for the first one: "A700"
  std::string warning;  ///< one line; empty: stored unchanged
};
StoreResponse store_response_of_json(const std::string& text);

}  // namespace simplexseg
