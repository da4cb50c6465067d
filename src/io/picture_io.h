// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

namespace simplexseg {

/// 8 bits for each of red, green and blue; rows from the top.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

/// Whether write_picture() knows the extension of `path`. Throws Error when it does not.
void require_picture_name(const std::filesystem::path& path);
/// Writes .png or .ppm, whole or not at all. Throws Error for another extension, an empty picture, a folder that does
/// not exist, or a failed write.
void write_picture(const std::filesystem::path& path, const Picture& picture);

}  // namespace simplexseg
