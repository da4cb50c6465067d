// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "core/error.h"

namespace simplexseg {

/// Returns the path in quotes for a message on one line; control characters are replaced.
std::string quoted(const std::filesystem::path& path);
/// Overload for paths stored as text; without it std::quoted would be selected.
inline std::string quoted(const std::string& path) { return quoted(std::filesystem::path(path)); }
/// Replaces each run of white space by one space and cuts the text after `limit` characters.
std::string one_line(const std::string& text, std::size_t limit = 300);
/// Returns a size for messages, e.g. "17.2 GB".
std::string format_bytes(double bytes);

/// Returns the extension in lower case, including double extensions such as ".nii.gz"; empty when there is none.
std::string extension_of(const std::filesystem::path& path);

/// Throws Error when `path` is not a regular file, cannot be opened or is empty.
void require_file(const std::filesystem::path& path);

/// Returns the Error for a failed write into `folder`; cause and remedy follow from `reason`, an errno value.
Error write_error(const std::string& what, const std::filesystem::path& folder, int reason);

/// Returns the contents of a file. Throws Error when it is missing, not a regular file, empty or unreadable.
std::string read_bytes(const std::filesystem::path& path);

}  // namespace simplexseg
