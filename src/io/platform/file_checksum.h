// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace simplexseg {

/// SHA-256 of the contents of a file (FIPS 180-4) in 64 hexadecimal digits, as `sha256sum` prints it. Throws Error if
/// the file cannot be read.
std::string sha256_of(const std::filesystem::path& file);
/// SHA-256 of the lines "CHECKSUM  NAME" of several files, sorted by name without folder: what
/// `LC_ALL=C sha256sum * | sha256sum` prints in their folder. Throws Error if a file cannot be read.
std::string sha256_of(std::vector<std::filesystem::path> files);

}  // namespace simplexseg
