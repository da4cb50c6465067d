// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "core/error.h"

namespace simplexseg {

/// The name of a file for a message: quoted, control characters replaced, so that a message stays one line.
std::string quoted(const std::filesystem::path& path);
/// The same for a path kept as text; without it std::quoted would be the better match.
inline std::string quoted(const std::string& path) { return quoted(std::filesystem::path(path)); }
/// Line breaks, tabs and runs of blanks become one blank each; cut after `limit` characters.
std::string one_line(const std::string& text, std::size_t limit = 300);
/// "17.2 GB": for messages.
std::string in_words(double bytes);

/// Lower-case extension from the last dot on, ".nii.gz"-like pairs whole; "" when there is none.
std::string extension_of(const std::filesystem::path& path);

/// Throws Error when `path` is no regular file, cannot be opened, or has no bytes.
void require_file(const std::filesystem::path& path);

/// The bytes of a file. Throws Error when it is missing, no file, empty or cannot be read.
std::string read_bytes(const std::filesystem::path& path);

}  // namespace simplexseg
