// SPDX-License-Identifier: Apache-2.0
// Checks of queries and order of their results, for both protocols.
#pragma once
#include <string>
#include <vector>

#include "archive/query.h"

namespace simplexseg {

/// Throws Error for a text that is too long or contains a backslash or a control character, an invalid study UID, or a
/// number of studies out of range.
void require_query(const ArchiveQuery& query);
/// Throws Error for a text that is not a UID. `what`: "study" or "series", for the message.
void require_uid(const std::string& uid, const char* what);
/// Pattern that matches values containing a text: "*text*"; a text with wildcards and an empty text are not changed.
std::string part_pattern(const std::string& text);
/// Sorts studies, the latest first, and truncates the list to `max_studies`, which sets FoundStudies::more.
void sort_studies(FoundStudies& found, int max_studies);
/// Sorts series by number.
void sort_series(std::vector<ArchiveSeries>& series);

}  // namespace simplexseg
