// SPDX-License-Identifier: Apache-2.0
#include "app/table.h"

#include <algorithm>
#include <cmath>
#include <ostream>

#include "core/number_text.h"

namespace simplexseg {
namespace {

/// Returns the number of UTF-8 characters, counted as the bytes that are not continuation bytes.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

}  // namespace

std::string fixed_or_dash(double value, int decimals) {
  return std::isfinite(value) ? fixed_text(value, decimals) : "-";
}

std::string readable(double value, int decimals) {
  const bool is_small = value != 0 && std::abs(value) < std::pow(10.0, 1 - decimals);
  return is_small ? general_text(value, 3) : fixed_or_dash(value, decimals);
}

void print_table(std::ostream& out, const std::vector<std::vector<std::string>>& rows, std::size_t first_right) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], width_of(row[c]));
  }
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string gap(widths[c] - width_of(row[c]), ' ');
      line += (c == 0 ? "" : "  ") + (c >= first_right ? gap + row[c] : row[c] + gap);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out << line << "\n";
  }
}

}  // namespace simplexseg
