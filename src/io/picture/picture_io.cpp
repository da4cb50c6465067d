// SPDX-License-Identifier: Apache-2.0
#include "io/picture/picture_io.h"

#include <zlib.h>

#include <string>

#include "core/error.h"
#include "io/platform/atomic_file.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

void append_u32(std::string& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xff);
}

/// Appends a PNG chunk: length, type, data and checksum (ISO/IEC 15948, section 5.3).
void append_chunk(std::string& bytes, const std::string& type, const std::string& data) {
  const std::string body = type + data;
  append_u32(bytes, static_cast<std::uint32_t>(data.size()));
  bytes += body;
  append_u32(bytes, static_cast<std::uint32_t>(
                        crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()))));
}

std::string png_bytes(const AtomicFile& file, const Picture& picture) {
  std::string header;
  append_u32(header, static_cast<std::uint32_t>(picture.width));
  append_u32(header, static_cast<std::uint32_t>(picture.height));
  header += {8, 2, 0, 0, 0};  // 8 bits, RGB, deflate, standard filters, not interlaced
  std::string rows;
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(picture.width);
  for (int y = 0; y < picture.height; ++y) {
    rows += '\0';  // filter: none
    rows.append(reinterpret_cast<const char*>(picture.rgb.data()) + static_cast<std::size_t>(y) * row_bytes, row_bytes);
  }
  uLongf size = compressBound(rows.size());
  std::string compressed(size, '\0');
  if (compress(reinterpret_cast<Bytef*>(compressed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
               rows.size()) != Z_OK) {
    throw file.failed("there is not enough memory to compress it", "close other programs");
  }
  compressed.resize(size);
  std::string bytes = "\x89PNG\r\n\x1a\n";
  append_chunk(bytes, "IHDR", header);
  append_chunk(bytes, "IDAT", compressed);
  append_chunk(bytes, "IEND", "");
  return bytes;
}

std::string ppm_bytes(const Picture& picture) {
  std::string bytes = "P6\n" + std::to_string(picture.width) + " " + std::to_string(picture.height) + "\n255\n";
  return bytes.append(picture.rgb.begin(), picture.rgb.end());
}

}  // namespace

void require_picture_name(const std::filesystem::path& path) {
  const std::string extension = extension_of(path);
  if (extension != ".png" && extension != ".ppm") {
    throw Error("cannot write " + quoted(path), "the extension '" + one_line(extension) + "' is not supported",
                "use .png or .ppm");
  }
}

void write_picture(const std::filesystem::path& path, const Picture& picture) {
  require_picture_name(path);
  const std::size_t expected = 3 * static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
  if (picture.width < 1 || picture.height < 1 || picture.rgb.size() != expected) {
    throw Error("cannot write " + quoted(path), "the picture is empty", "create the picture first");
  }
  AtomicFile file(path);
  write_bytes(file, extension_of(path) == ".png" ? png_bytes(file, picture) : ppm_bytes(picture));
  file.commit();
}

}  // namespace simplexseg
