// SPDX-License-Identifier: Apache-2.0
// Queries and their results, for both protocols.
#pragma once
#include <string>
#include <vector>

#include "archive/query.h"

namespace simplexseg {

/// Throws Error for a text that cannot be searched for, or a number out of range.
void require_query(const ArchiveQuery& query);
/// Throws Error for a text that is not a UID. `what`: "study" or "series", for the message.
void require_uid(const std::string& uid, const char* what);
/// Pattern that matches values containing the text: "*text*", or the text itself if it contains wildcards.
std::string part_pattern(const std::string& text);
/// Sorts studies, latest first, and truncates the list to `max_studies`.
void sort_studies(FoundStudies& found, int max_studies);
/// Sorts series by number.
void sort_series(std::vector<ArchiveSeries>& series);

}  // namespace simplexseg
