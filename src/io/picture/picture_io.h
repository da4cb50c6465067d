// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

namespace simplexseg {

/// RGB image with 8 bits per channel, rows from the top; width and height in pixels.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

/// Throws Error if write_picture() does not support the extension of `path`.
void require_picture_name(const std::filesystem::path& path);
/// Writes .png or .ppm through a temporary file. Throws Error for another extension, a picture that is empty or whose
/// data do not match its size, a missing folder, or a failed write.
void write_picture(const std::filesystem::path& path, const Picture& picture);

}  // namespace simplexseg
