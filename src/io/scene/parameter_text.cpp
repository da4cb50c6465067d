// SPDX-License-Identifier: Apache-2.0
#include "io/scene/parameter_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

#include "core/error.h"
#include "core/expect.h"
#include "core/number_text.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

int edit_distance(std::string_view a, std::string_view b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i) + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const int substituted = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substituted, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

std::string range_text(const ParameterInfo& info) {
  return number_to_text(info.minimum) + " to " + number_to_text(info.maximum);
}

}  // namespace

std::vector<std::string> choices_of(const ParameterInfo& info) {
  std::vector<std::string> names;
  if (info.kind != ParameterKind::Choice) return names;
  std::string_view rest = info.choices;
  while (!rest.empty()) {
    const std::size_t bar = rest.find('|');
    names.emplace_back(rest.substr(0, bar));
    rest = bar == std::string_view::npos ? std::string_view{} : rest.substr(bar + 1);
  }
  return names;
}

float checked_parameter(const std::string& where, const ParameterInfo& info, double value) {
  if (!std::isfinite(value)) throw Error(where, "the number is not finite", "use a value from " + range_text(info));
  const float narrow = static_cast<float>(value);  // compared as float, like the limits in the tables
  if (!(narrow >= info.minimum && narrow <= info.maximum)) {
    throw Error(where, number_to_text(narrow) + " is out of range", "use a value from " + range_text(info));
  }
  if (info.kind != ParameterKind::Real && narrow != std::round(narrow)) {
    throw Error(where, number_to_text(narrow) + " is not a whole number",
                "use a whole number from " + range_text(info));
  }
  return narrow;
}

float choice_from_text(const std::string& where, const ParameterInfo& info, const std::string& text) {
  const std::vector<std::string> names = choices_of(info);
  const auto found = std::find(names.begin(), names.end(), text);
  if (found != names.end()) return static_cast<float>(found - names.begin());
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  throw Error(where, unknown_name(text, names), "use one of " + all);
}

float parameter_from_text(const std::string& where, const ParameterInfo& info, const std::string& text) {
  if (info.kind == ParameterKind::Choice) return choice_from_text(where, info, text);
  const std::optional<double> value = parse_number(text);
  if (!value) throw Error(where, "'" + text + "' is not a number", "use a value from " + range_text(info));
  return checked_parameter(where, info, *value);
}

std::string parameter_to_text(const ParameterInfo& info, float value) {
  if (info.kind == ParameterKind::Choice) {
    const std::vector<std::string> names = choices_of(info);
    return names[std::clamp<long>(std::lround(value), 0, static_cast<long>(names.size()) - 1)];
  }
  return number_to_text(info.kind == ParameterKind::Integer ? std::round(value) : value);
}

std::string number_to_text(float value) {
  char text[40];
  const bool whole = value == std::trunc(value) && std::abs(value) < 1e7f && !(value == 0 && std::signbit(value));
  const auto end = whole ? std::to_chars(text, text + sizeof text, static_cast<int>(value))
                         : std::to_chars(text, text + sizeof text, value);
  return {text, end.ptr};
}

double short_double(float value) {
  if (!std::isfinite(value)) return value;
  const double wide = parse_number(number_to_text(value)).value_or(value);
  return static_cast<float>(wide) == value ? wide : static_cast<double>(value);
}

std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates) {
  SIMPLEXSEG_EXPECT(!candidates.empty());
  return *std::min_element(candidates.begin(), candidates.end(), [name](const std::string& a, const std::string& b) {
    return edit_distance(name, a) < edit_distance(name, b);
  });
}

std::string unknown_name(std::string_view name, const std::vector<std::string>& candidates) {
  const std::string quoted = std::string("'").append(one_line(std::string(name))).append("' is unknown");
  return candidates.empty() ? quoted : quoted + ", the nearest known is '" + nearest_name(name, candidates) + "'";
}

std::vector<std::string> names_of(std::span<const ParameterInfo> table) {
  std::vector<std::string> names;
  for (const ParameterInfo& info : table) names.emplace_back(info.name);
  return names;
}

std::vector<std::string> names_of(std::span<const ForceInfo> forces) {
  std::vector<std::string> names;
  for (const ForceInfo& info : forces) names.emplace_back(info.name);
  return names;
}

}  // namespace simplexseg
