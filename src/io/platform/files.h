// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "core/error.h"

namespace simplexseg {

/// Returns the path in quotes for messages, on one line, see one_line().
std::string quoted(const std::filesystem::path& path);
/// Overload for paths stored as text; without it std::quoted would be selected.
inline std::string quoted(const std::string& path) { return quoted(std::filesystem::path(path)); }
/// Returns the text on one line for messages: each run of spaces and control characters becomes one space, spaces at
/// both ends are removed, and " ..." replaces the text after `limit` bytes.
std::string one_line(const std::string& text, std::size_t limit = 300);
/// Returns the message of an exception on one line, without a period at its end.
std::string message_of(const std::exception& exception);
/// Returns a number of bytes as text for messages, e.g. "17.2 GB".
std::string format_bytes(double bytes);

/// Returns the extension in lower case with its period, including the extension before ".gz", e.g. ".nii.gz"; empty
/// when there is none.
std::string extension_of(const std::filesystem::path& path);

/// Throws Error when `path` does not exist, is not a regular file, cannot be opened or is empty.
void require_file(const std::filesystem::path& path);

/// Returns the Error for a failed write into `folder`. `what` states what failed; cause and remedy follow from
/// `reason`, an errno value.
Error write_error(const std::string& what, const std::filesystem::path& folder, int reason);

/// Returns the contents of a file. Throws Error when it is missing, not a regular file, empty or unreadable.
std::string read_bytes(const std::filesystem::path& path);

}  // namespace simplexseg
