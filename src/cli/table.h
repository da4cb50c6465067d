// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <iosfwd>
#include <string>
#include <vector>

namespace simplexseg {

/// Fixed decimals, as people read them; "-" for what is not finite.
std::string fixed(double value, int decimals);

/// Lines whose columns stand below each other; the first is the heading. Columns from `first_right` on stand right.
void print_table(std::ostream& out, const std::vector<std::vector<std::string>>& rows, std::size_t first_right);

}  // namespace simplexseg
