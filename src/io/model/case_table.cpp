// SPDX-License-Identifier: Apache-2.0
#include "io/model/case_table.h"

#include <algorithm>
#include <array>

#include "core/error.h"
#include "io/platform/data_path.h"
#include "io/platform/files.h"

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

}  // namespace

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
    one.labels = find_data(field(labels), path.parent_path());
    one.label = field(label);
    one.mirror = mirrored == "1";
    one.name = field(name).empty() ? one.image.filename().string() : field(name);
  }
  if (cases.empty()) throw Error(table, "it has no case", "add a row for each case");
  return cases;
}

}  // namespace simplexseg
