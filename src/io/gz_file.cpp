// SPDX-License-Identifier: Apache-2.0
#include "io/gz_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "io/files.h"

namespace simplexseg {

GzReader::GzReader(const std::filesystem::path& path) {
  require_file(path);
  file_bytes_ = static_cast<double>(std::filesystem::file_size(path));
  file_ = gzopen(path.c_str(), "rb");
  if (!file_) throw Error("cannot read " + quoted(path), std::strerror(errno), "check its permissions");
  gzbuffer(file_, 1 << 18);
  packed_ = gzdirect(file_) == 0;
}

GzReader::~GzReader() { gzclose(file_); }

std::size_t GzReader::read(void* to, std::size_t bytes) {
  std::size_t done = 0;
  while (done < bytes) {
    const unsigned wanted = static_cast<unsigned>(std::min<std::size_t>(bytes - done, 1u << 30));
    const int got = gzread(file_, static_cast<char*>(to) + done, wanted);
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

bool GzReader::skip(std::size_t bytes) {
  std::vector<char> block(std::min<std::size_t>(bytes, 1 << 16));
  while (bytes > 0) {
    const std::size_t chunk = std::min(bytes, block.size());
    if (read(block.data(), chunk) != chunk) return false;
    bytes -= chunk;
  }
  return true;
}

bool GzReader::damaged() const {
  int code = Z_OK;
  gzerror(file_, &code);
  return code == Z_DATA_ERROR;
}

bool GzReader::damaged_at_end() {
  char byte;
  const int got = gzread(file_, &byte, 1);  // makes zlib look at the trailer
  int code = Z_OK;
  gzerror(file_, &code);
  return got < 0 || (code != Z_OK && code != Z_STREAM_END);
}

double GzReader::most_bytes() const { return packed_ ? 1032 * file_bytes_ : file_bytes_; }

}  // namespace simplexseg
