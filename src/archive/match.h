// SPDX-License-Identifier: Apache-2.0
// What both protocols do with a query and with its answers.
#pragma once
#include <string>
#include <vector>

#include "archive/query.h"

namespace simplexseg {

/// Throws Error where a text cannot be searched for, or a number is out of its bounds.
void require_query(const ArchiveQuery& query);
/// Throws Error. `what`: "study", "series".
void require_uid(const std::string& uid, const char* what);
/// A text that is to be a part of the value: "*text*", unless it has wildcards of its own.
std::string part_pattern(const std::string& text);
/// Puts the latest first and cuts them to as many as were asked for.
void sort_studies(FoundStudies& found, int most);
void sort_series(std::vector<ArchiveSeries>& series);

}  // namespace simplexseg
