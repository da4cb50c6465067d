// SPDX-License-Identifier: Apache-2.0
#include "archive/query.h"

#include <algorithm>

#include "archive/match.h"
#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

/// Converts a date such as "2024-05-31" to "20240531"; "" for other texts and impossible dates.
std::string day_of(const std::string& text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return {};
  const std::string day = text.substr(0, 4) + text.substr(5, 2) + text.substr(8, 2);
  if (!std::all_of(day.begin(), day.end(), is_ascii_digit)) return {};
  const auto part = [&day](std::size_t at, std::size_t size) {
    return static_cast<int>(*parse_integer(std::string_view(day).substr(at, size)));
  };
  const int year = part(0, 4), month = part(4, 2), date = part(6, 2);
  constexpr int kDays[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  if (month < 1 || month > 12) return {};
  const bool leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
  return date >= 1 && date <= kDays[month - 1] + (leap && month == 2) ? day : "";
}

}  // namespace

std::string dicom_date_range(const std::string& date) {
  if (date.empty()) return {};
  const std::size_t range = date.find("..");
  const std::string from = date.substr(0, range), to = range == std::string::npos ? "" : date.substr(range + 2);
  const std::string first = day_of(from), last = day_of(to);
  const bool is_day = range == std::string::npos;
  const auto fail = [&](const char* why) {
    throw Error("the date " + one_line(date, 40), why,
                "use a date such as 2024-05-31 or a range such as 2024-01-01..2024-12-31");
  };
  if ((!from.empty() && first.empty()) || (!to.empty() && last.empty()) || (first.empty() && last.empty()))
    fail("it is not a date");
  if (!first.empty() && !last.empty() && last < first) fail("it ends before it begins");
  return is_day ? first : first + "-" + last;
}

bool is_dicom_uid(const std::string& text) {
  return !text.empty() && text.size() <= 64 && text.front() != '.' && text.back() != '.' &&
         text.find("..") == std::string::npos &&
         std::all_of(text.begin(), text.end(), [](char c) { return c == '.' || is_ascii_digit(c); });
}

void require_query(const ArchiveQuery& query) {
  for (const auto& [what, text] :
       {std::pair("patient's name", &query.patient_name), std::pair("patient's id", &query.patient_id),
        std::pair("modality", &query.modality), std::pair("description", &query.description)})
    if (text->size() > 64 ||
        std::any_of(text->begin(), text->end(), [](unsigned char c) { return c < 0x20 || c == '\\'; }))
      throw Error(std::string("the ") + what + " to search for",
                  text->size() > 64 ? "it is too long" : "it contains a backslash or a control character",
                  text->size() > 64 ? "use at most 64 characters" : "remove that character");
  if (!query.study.empty()) require_uid(query.study, "study");
  if (query.max_studies < 1 || query.max_studies > 10000)
    throw Error("the number of studies to find", std::to_string(query.max_studies) + " is out of range",
                "use 1 to 10000");
}

void require_uid(const std::string& uid, const char* what) {
  if (!is_dicom_uid(uid))
    throw Error(std::string("the UID of the ") + what, "'" + one_line(uid, 70) + "' is not a UID",
                "use a UID printed by archive find");
}

std::string part_pattern(const std::string& text) {
  return text.empty() || text.find_first_of("*?") != std::string::npos ? text : "*" + text + "*";
}

void sort_studies(FoundStudies& found, int max_studies) {
  std::stable_sort(found.studies.begin(), found.studies.end(),
                   [](const ArchiveStudy& a, const ArchiveStudy& b) { return a.date > b.date; });
  if (found.studies.size() > static_cast<std::size_t>(max_studies)) {
    found.studies.resize(static_cast<std::size_t>(max_studies));
    found.more = true;
  }
}

void sort_series(std::vector<ArchiveSeries>& series) {
  std::stable_sort(series.begin(), series.end(),
                   [](const ArchiveSeries& a, const ArchiveSeries& b) { return a.number < b.number; });
}

}  // namespace simplexseg
