// SPDX-License-Identifier: Apache-2.0
// Answers in DICOM's JSON model (PS3.18, F), held at arm's length: whatever has not the form that the standard gives it
// counts as absent.
#pragma once
#include <set>
#include <string>
#include <vector>

#include "archive/archive.h"

namespace simplexseg {

// Each throws Error, with the server's name, where the text is not JSON, no list of objects, or nested beyond reason.
// Entries without a UID are left out.
std::vector<ArchiveStudy> studies_of_json(const ArchiveServer& server, const std::string& text);
std::vector<ArchiveSeries> series_of_json(const ArchiveServer& server, const std::string& text,
                                          const std::string& study);
std::set<std::string> instances_of_json(const ArchiveServer& server, const std::string& text);

/// What an archive says of instances that it was sent (PS3.18, 10.5.3).
struct StoreAnswer {
  int refused = 0;
  std::string reason;   ///< of the first one: "A700"
  std::string warning;  ///< one line; empty where it changed nothing
};
StoreAnswer store_answer_of_json(const std::string& text);

}  // namespace simplexseg
