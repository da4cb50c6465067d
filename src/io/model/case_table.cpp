// SPDX-License-Identifier: Apache-2.0
#include "io/model/case_table.h"

#include <algorithm>
#include <array>
#include <functional>
#include <utility>

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/data_path.h"
#include "io/platform/files.h"
#include "io/platform/header_text.h"

namespace simplexseg {
namespace {

/// Fields of the rows of a CSV text (RFC 4180).
std::vector<std::vector<std::string>> csv_rows(const std::string& text, char separator) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> row;
  std::string field;
  bool quoted_field = false;
  const auto end_field = [&] { row.push_back(std::exchange(field, {})); };
  const auto end_row = [&] {
    end_field();
    rows.push_back(std::exchange(row, {}));
  };
  for (std::size_t c = 0; c < text.size(); ++c) {
    const char at = text[c];
    if (quoted_field) {
      if (at != '"')
        field += at;
      else if (c + 1 < text.size() && text[c + 1] == '"')
        field += text[++c];
      else
        quoted_field = false;
    } else if (at == '"') {
      quoted_field = true;
    } else if (at == separator) {
      end_field();
    } else if (at == '\n') {
      end_row();
    } else if (at != '\r') {
      field += at;
    }
  }
  if (!field.empty() || !row.empty()) end_row();
  return rows;
}

std::string joined(const std::vector<std::string>& entries) {
  if (std::ranges::adjacent_find(entries, std::not_equal_to<>()) == entries.end()) return entries.front();
  std::string text;
  for (const std::string& entry : entries) text += (&entry == &entries.front() ? "" : ";") + entry;
  return text;
}

}  // namespace

std::vector<std::string> list_entries(const std::string& text) {
  std::vector<std::string> entries;
  std::size_t start = 0;
  for (std::size_t end = 0; end != text.npos; start = end + 1) {
    end = text.find(';', start);
    entries.push_back(trimmed(text.substr(start, end - start)));
  }
  return entries;
}

std::vector<OrganLabels> organ_labels(const std::string& files, const std::string& labels,
                                      const std::function<std::filesystem::path(const std::string&)>& file) {
  std::vector<std::string> file_list = list_entries(files), label_list = list_entries(labels);
  const std::size_t count = std::max(file_list.size(), label_list.size());
  if ((file_list.size() != 1 && file_list.size() != count) || (label_list.size() != 1 && label_list.size() != count))
    throw Error("labels '" + one_line(files, 100) + "'",
                counted(file_list.size(), "label file", "label files") + " for " +
                    counted(label_list.size(), "label", "labels"),
                "write as many of both, or one for all");
  const bool has_files = file_list.size() > 1, has_labels = label_list.size() > 1;
  file_list.resize(count, file_list.front()), label_list.resize(count, label_list.front());
  std::vector<OrganLabels> organs(count);
  for (std::size_t k = 0; k < count; ++k) {
    if ((has_files && file_list[k].empty()) || (has_labels && label_list[k].empty())) continue;
    organs[k] = {file(file_list[k]), label_list[k]};
  }
  return organs;
}

std::string files_text(const std::vector<OrganLabels>& organs) {
  std::vector<std::string> entries;
  std::filesystem::path only;
  for (const OrganLabels& one : organs) {
    entries.push_back(one.labels.string());
    if (!one.labels.empty()) only = one.labels;
  }
  // One file for all, of which some have no label.
  if (std::ranges::all_of(organs, [&](const OrganLabels& one) { return one.labels.empty() || one.labels == only; }))
    return only.string();
  return joined(entries);
}

std::string labels_text(const std::vector<OrganLabels>& organs) {
  std::vector<std::string> entries;
  entries.reserve(organs.size());
  for (const OrganLabels& one : organs) entries.push_back(one.label);
  return joined(entries);
}

std::vector<TableCase> read_case_table(const std::filesystem::path& path) {
  std::string text = read_bytes(path);
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
  const std::string head = text.substr(0, text.find('\n'));
  char separator = ',';
  for (const char other : {';', '\t'})
    if (std::ranges::count(head, other) > std::ranges::count(head, separator)) separator = other;
  const auto rows = csv_rows(text, separator);
  const std::string table = "table " + quoted(path);
  const auto column = [&](std::initializer_list<const char*> names) -> std::ptrdiff_t {
    for (const char* name : names)
      if (const auto at = std::ranges::find(rows[0], name); at != rows[0].end()) return at - rows[0].begin();
    return -1;
  };
  if (rows.empty()) throw Error(table, "it is empty", "write a row of column names and a row for each case");
  const std::ptrdiff_t image = column({"image"}), labels = column({"labels", "reference"}), name = column({"name"}),
                       label = column({"label", "reference_label"}), mirror = column({"mirror"});
  if (image < 0 || labels < 0)
    throw Error(table, std::string("the column '") + (image < 0 ? "image" : "labels") + "' is missing",
                "name the columns in the first row");
  std::vector<TableCase> cases;
  for (std::size_t r = 1; r < rows.size(); ++r) {
    const std::vector<std::string>& row = rows[r];
    if (std::ranges::all_of(row, [](const std::string& field) { return field.empty(); })) continue;
    const auto field = [&](std::ptrdiff_t at) {
      return at >= 0 && at < std::ssize(row) ? row[static_cast<std::size_t>(at)] : std::string();
    };
    const auto missing = [&](const char* what) {
      return Error(table, "row " + std::to_string(r + 1) + " has no " + what, "complete the row");
    };
    if (field(image).empty()) throw missing("image");
    if (field(labels).empty()) throw missing("labels");
    const std::string mirrored = field(mirror);
    if (!mirrored.empty() && mirrored != "0" && mirrored != "1")
      throw Error(table, "row " + std::to_string(r + 1) + ": mirror is '" + one_line(mirrored) + "'", "write 0 or 1");
    TableCase& one = cases.emplace_back();
    one.image = find_data(field(image), path.parent_path());
    one.organs = organ_labels(field(labels), field(label),
                              [&](const std::string& file) { return find_data(file, path.parent_path()); });
    if (one.organs.size() != cases.front().organs.size())
      throw Error(table,
                  "row " + std::to_string(r + 1) + " has " + counted(one.organs.size(), "organ", "organs") +
                      ", but the first case has " + std::to_string(cases.front().organs.size()),
                  "leave entries of organs that are not labelled empty, as in 2;;4");
    one.mirror = mirrored == "1";
    one.name = field(name).empty() ? one.image.filename().string() : field(name);
  }
  if (cases.empty()) throw Error(table, "it has no case", "add a row for each case");
  return cases;
}

}  // namespace simplexseg
