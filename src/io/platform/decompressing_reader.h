// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

namespace simplexseg {

enum class Compression : std::uint8_t { None, Deflate, Bzip2 };  ///< Deflate: in a gzip or zlib stream

/// Sequential reader of a file from a given offset; compressed data is decompressed on the fly.
class DecompressingReader {
 public:
  /// Opens the file at its start. A gzip stream is detected by its first bytes, not by the file name. Throws Error when
  /// the file is missing, empty or cannot be opened.
  explicit DecompressingReader(const std::filesystem::path& path);
  /// Opens the file at byte `offset`. Throws Error like the other constructor.
  DecompressingReader(const std::filesystem::path& path, Compression compression, std::uint64_t offset = 0);
  ~DecompressingReader();
  DecompressingReader(const DecompressingReader&) = delete;
  DecompressingReader& operator=(const DecompressingReader&) = delete;

  /// Reads up to `bytes` bytes and returns their number: fewer at the end of the file or at damaged data (damaged()).
  std::size_t read(void* to, std::size_t bytes);
  /// Skips `bytes` bytes; returns false when the file ends before.
  bool skip(std::uint64_t bytes);
  /// Returns true when the checksum of the stream is wrong or its end is missing. Call it once, after the last read.
  bool damaged_at_end();
  /// Returns true when the compressed data read so far is damaged; the end of the file alone is not damage.
  bool damaged() const { return damaged_; }
  bool is_compressed() const { return compression_ != Compression::None; }
  /// Upper bound of the number of decompressed bytes after the offset. Deflate expands a byte to at most 1032
  /// bytes; a bzip2 block has at least 30 bytes and expands to at most 46 MB.
  double max_bytes() const;

 private:
  struct Stream;
  void open(const std::filesystem::path& path, Compression compression, std::uint64_t offset);
  bool fill();
  std::size_t read_file(void* to, std::size_t bytes);
  std::size_t read_deflate(void* to, std::size_t bytes);
  std::size_t read_bzip2(void* to, std::size_t bytes);

  int descriptor_ = -1;
  std::uint64_t begin_ = 0, next_ = 0;  ///< offsets of the data and of the next byte of uncompressed data
  std::uint64_t file_bytes_ = 0;        ///< size of the file
  Compression compression_ = Compression::None;
  bool damaged_ = false, ended_ = false;
  std::unique_ptr<Stream> stream_;
};

}  // namespace simplexseg
