// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <zlib.h>

#include <filesystem>

namespace simplexseg {

/// A file read from its start, unpacked on the way when it is gzip'ed (told by its first bytes, not by its name).
class GzReader {
 public:
  /// Throws Error when the file is missing, empty or cannot be opened.
  explicit GzReader(const std::filesystem::path& path);
  ~GzReader();
  GzReader(const GzReader&) = delete;
  GzReader& operator=(const GzReader&) = delete;

  /// Reads up to `bytes`; fewer at the end of the file, or where the packed stream is damaged (see damaged()).
  std::size_t read(void* to, std::size_t bytes);
  /// Skips `bytes`; false when the file ends before.
  bool skip(std::size_t bytes);
  /// To be called once all that was wanted is read: true when the stream's checksum is wrong or its end is missing.
  bool damaged_at_end();
  /// True when what was read so far met packed data that are wrong; false at a mere end of the file.
  bool damaged() const;
  bool packed() const { return packed_; }
  /// The most bytes that can come out: the file's size, or 1032 times that (the best that deflate can do).
  double most_bytes() const;

 private:
  gzFile file_;
  double file_bytes_;
  bool packed_;
};

}  // namespace simplexseg
