// SPDX-License-Identifier: Apache-2.0
#include "io/volume/nrrd_header.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "core/number_text.h"
#include "io/platform/files.h"
#include "io/platform/header_text.h"

namespace simplexseg {

namespace {

/// Normalised name of a field: in lower case, with the blank that some names may lack ("datafile").
std::string field_name(const std::string& text) {
  std::string name = lower_ascii(trimmed(text));
  for (const char* joined : {"data file", "line skip", "byte skip", "axis mins", "axis maxs", "block size"}) {
    std::string other(joined);
    other.erase(other.find(' '), 1);
    if (name == other) return joined;
  }
  return name == "centerings" ? "centers" : name;
}

/// Components of a vector without its parentheses, separated by commas or, without any, by blanks.
std::vector<std::string> components_of(const std::string& vector) {
  if (vector.find(',') == std::string::npos) return words_of(vector);
  std::vector<std::string> components;
  for (std::size_t first = 0; first <= vector.size();) {
    const std::size_t comma = std::min(vector.find(',', first), vector.size());
    components.push_back(trimmed(vector.substr(first, comma - first)));
    first = comma + 1;
  }
  return components;
}

}  // namespace

void NrrdHeader::fail(const std::string& why, const std::string& what_to_do) const {
  throw Error("cannot read " + quoted(path_), why, what_to_do);
}

NrrdHeader::NrrdHeader(const std::filesystem::path& path) : path_(path) {
  HeaderLines lines(path);
  std::optional<std::string> line = lines.next();
  if (!line || !line->starts_with("NRRD000"))
    fail("it is not a readable NRRD file", "rename it with the extension of its format");
  bool lists_files = false;
  while ((line = lines.next()) && (lists_files || !trimmed(*line).empty())) {
    if (lists_files) {
      if (!trimmed(*line).empty()) listed_.push_back(trimmed(*line));
      continue;
    }
    const std::size_t colon = line->find(':');
    if (line->starts_with('#') || colon == std::string::npos) continue;
    // Key/value pair. Its value may contain a colon.
    if (const std::size_t at = line->find(":="); at != std::string::npos && at == colon) {
      keys_.emplace(line->substr(0, at), trimmed(line->substr(at + 2)));
      continue;
    }
    const std::string name = field_name(line->substr(0, colon)), value = trimmed(line->substr(colon + 1));
    if (!fields_.emplace(name, value).second) fail("its field '" + one_line(name, 60) + "' occurs twice");
    lists_files = name == "data file" && lower_ascii(value).starts_with("list");
  }
  bytes_ = lines.bytes_read();
  const std::int64_t dimension = integer("dimension", 0, 1, 16);
  for (const std::string& word : words("sizes", static_cast<std::size_t>(dimension))) {
    const auto size = number_of<std::int64_t>(word);
    if (!size || *size < 1 || *size > std::numeric_limits<int>::max())
      fail("its field 'sizes' claims '" + one_line(word, 60) + "' voxels along an axis");
    sizes_.push_back(*size);
  }
  if (sizes_.empty()) fail("its header has no sizes");
}

std::string NrrdHeader::text(const std::string& field) const {
  const auto found = fields_.find(field);
  return found == fields_.end() ? "" : found->second;
}

std::string NrrdHeader::key(const std::string& name) const {
  const auto found = keys_.find(name);
  return found == keys_.end() ? "" : found->second;
}

std::int64_t NrrdHeader::integer(const std::string& field, std::int64_t otherwise, std::int64_t minimum,
                                 std::int64_t maximum) const {
  if (!has(field) && otherwise >= minimum) return otherwise;
  const auto value = number_of<std::int64_t>(text(field));
  if (!value || *value < minimum || *value > maximum)
    fail("its field '" + field + "' is '" + one_line(text(field), 60) + "', not a whole number from " +
         std::to_string(minimum) + " to " + std::to_string(maximum));
  return *value;
}

std::vector<std::string> NrrdHeader::words(const std::string& field, std::size_t count) const {
  std::vector<std::string> found;
  const std::string value = text(field);
  for (std::size_t at = 0; at < value.size();) {
    if (value[at] == ' ' || value[at] == '\t') {
      ++at;
      continue;
    }
    const bool in_quotes = value[at] == '"';
    const std::size_t first = at + (in_quotes ? 1 : 0);
    at = std::min(value.size(), value.find_first_of(in_quotes ? "\"" : " \t", first));
    found.push_back(value.substr(first, at - first));
    if (in_quotes) ++at;
  }
  if (has(field) && found.size() != count)
    fail("its field '" + field + "' has " + std::to_string(found.size()) + " values instead of " +
         std::to_string(count));
  return found;
}

std::vector<double> NrrdHeader::numbers(const std::string& field) const {
  std::vector<double> values;
  for (const std::string& word : words(field, sizes_.size())) {
    const auto value = number_of<double>(lower_ascii(word));
    if (!value) fail("its field '" + field + "' has '" + one_line(word, 60) + "', which is not a number");
    values.push_back(*value);
  }
  return values;
}

std::vector<std::vector<double>> NrrdHeader::vectors(const std::string& field, std::size_t count, int dimension) const {
  std::vector<std::vector<double>> found;
  const std::string value = text(field);
  const auto unusable = [&] {
    fail("its field '" + field + "' is '" + one_line(value, 100) + "', not vectors of " + std::to_string(dimension) +
         " numbers with a decimal point, separated by commas");
  };
  for (std::size_t at = value.find_first_not_of(" \t"); at < value.size(); at = value.find_first_not_of(" \t", at)) {
    std::vector<double>& vector = found.emplace_back();
    if (lower_ascii(value.substr(at, 4)) == "none") {
      at += 4;
      continue;
    }
    const std::size_t end = value.find(')', at);
    if (value[at] != '(' || end == std::string::npos) unusable();
    for (const std::string& word : components_of(value.substr(at + 1, end - at - 1))) {
      const auto number = number_of<double>(lower_ascii(word));
      if (!number) unusable();
      vector.push_back(*number);
    }
    if (vector.size() != static_cast<std::size_t>(dimension)) unusable();
    at = end + 1;
  }
  if (has(field) && found.size() != count) unusable();
  return found;
}

}  // namespace simplexseg
