// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <iosfwd>
#include <string>
#include <vector>

namespace simplexseg {

/// Formats a number with fixed decimals; "-" if it is not finite.
std::string fixed_or_dash(double value, int decimals);
/// Formats a number like fixed_or_dash(), but with three significant digits if fewer than two would remain.
std::string readable(double value, int decimals);

/// Prints rows with aligned columns; the first row contains the headings. Columns from index `first_right` on are
/// right-aligned.
void print_table(std::ostream& out, const std::vector<std::vector<std::string>>& rows, std::size_t first_right);

}  // namespace simplexseg
