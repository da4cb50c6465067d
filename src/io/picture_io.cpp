// SPDX-License-Identifier: Apache-2.0
#include "io/picture_io.h"

#include <zlib.h>

#include <string>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/files.h"

namespace simplexseg {
namespace {

void put_u32(std::string& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xff);
}

/// Length, type, data and checksum, as the PNG specification (ISO/IEC 15948, section 5.3) lays a chunk out.
void put_chunk(std::string& bytes, const std::string& type, const std::string& data) {
  const std::string body = type + data;
  put_u32(bytes, static_cast<std::uint32_t>(data.size()));
  bytes += body;
  put_u32(bytes, static_cast<std::uint32_t>(
                     crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()))));
}

std::string png_bytes(const AtomicFile& file, const Picture& picture) {
  std::string header;
  put_u32(header, static_cast<std::uint32_t>(picture.width));
  put_u32(header, static_cast<std::uint32_t>(picture.height));
  header += {8, 2, 0, 0, 0};  // 8 bits, RGB, deflate, the standard filters, not interlaced
  std::string rows;
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(picture.width);
  for (int y = 0; y < picture.height; ++y) {
    rows += '\0';  // filter: none
    rows.append(reinterpret_cast<const char*>(picture.rgb.data()) + static_cast<std::size_t>(y) * row_bytes, row_bytes);
  }
  uLongf size = compressBound(rows.size());
  std::string packed(size, '\0');
  if (compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
               rows.size()) != Z_OK) {
    throw file.failed("the picture cannot be compressed");
  }
  packed.resize(size);
  std::string bytes = "\x89PNG\r\n\x1a\n";
  put_chunk(bytes, "IHDR", header);
  put_chunk(bytes, "IDAT", packed);
  put_chunk(bytes, "IEND", "");
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
    throw Error("cannot write " + quoted(path), "the extension is none of a picture's", "name it .png or .ppm");
  }
}

void write_picture(const std::filesystem::path& path, const Picture& picture) {
  require_picture_name(path);
  const std::size_t expected = 3 * static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
  if (picture.width < 1 || picture.height < 1 || picture.rgb.size() != expected) {
    throw Error("cannot write " + quoted(path), "the picture is empty", "draw something first");
  }
  AtomicFile file(path);
  write_bytes(file, extension_of(path) == ".png" ? png_bytes(file, picture) : ppm_bytes(picture));
  file.commit();
}

}  // namespace simplexseg
