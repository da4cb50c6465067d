// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

namespace simplexseg {

/// Converts names typed by users to file names without extension, one for each name and in the same order. They are
/// - safe on all common file systems: UTF-8, about 120 bytes at most, without control characters, path separators and
///   other characters that Windows forbids, and without leading or trailing periods and spaces;
/// - distinct, also on file systems that ignore case: a name already in use gets the suffix "-2", "-3" and so on;
/// - stable: a file name depends only on the names before it, so appending names changes none of the others.
/// A name without any valid character becomes `otherwise`.
std::vector<std::string> distinct_file_names(const std::vector<std::string>& names, const std::string& otherwise);

}  // namespace simplexseg
