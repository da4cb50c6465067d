// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

namespace simplexseg {

/// Converts names typed by users to file names without extension, one for each name and in the same order. The file
/// names are
/// - valid on all common file systems: UTF-8, at most 120 bytes plus suffix, without leading or trailing periods and
///   spaces; control characters, path separators and other characters that Windows forbids become "_";
/// - distinct, also on file systems that ignore case: a name already in use gets the suffix "-2", "-3" and so on;
/// - stable: a file name depends only on its own name and the names before it, so appended names change no other.
/// A name that is empty or has only spaces becomes `otherwise`.
std::vector<std::string> distinct_file_names(const std::vector<std::string>& names, const std::string& otherwise);

}  // namespace simplexseg
