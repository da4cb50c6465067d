// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

namespace simplexseg {

/// Names for files, without extension, from names that people gave, one for each and in their order. They are
/// - safe on any file system in use: UTF-8, some 120 bytes at most, without control characters, what separates folders
///   and the other characters that Windows refuses, and without dots and blanks at the ends;
/// - distinct, on file systems too that take capital and small letters for the same: a name that is taken gets "-2",
///   "-3" and so on;
/// - stable: a name depends on those before it alone, so what is added at the end changes none.
/// A name of which nothing is left becomes `otherwise`.
std::vector<std::string> distinct_file_names(const std::vector<std::string>& names, const std::string& otherwise);

}  // namespace simplexseg
