// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

namespace simplexseg {

enum class Compression : std::uint8_t { None, Deflate, Bzip2 };  ///< Deflate: gzip or zlib stream

/// Sequential reader of a file from a given offset, which decompresses compressed data during reading.
class DecompressingReader {
 public:
  /// Opens the file at its start. A gzip stream is detected by the first bytes of the file, not by its name. Throws
  /// Error when the file is missing, empty or cannot be opened.
  explicit DecompressingReader(const std::filesystem::path& path);
  /// Opens the file `offset` bytes after its start. Throws Error like the other constructor.
  DecompressingReader(const std::filesystem::path& path, Compression compression, std::uint64_t offset = 0);
  ~DecompressingReader();
  DecompressingReader(const DecompressingReader&) = delete;
  DecompressingReader& operator=(const DecompressingReader&) = delete;

  /// Reads up to `bytes` decompressed bytes and returns their number, which is smaller at the end of the file or at
  /// damaged data (damaged()).
  std::size_t read(void* to, std::size_t bytes);
  /// Skips `bytes` decompressed bytes. Returns false when the file or its undamaged data ends earlier.
  bool skip(std::uint64_t bytes);
  /// Returns true when the checksum of the stream is wrong or its end is missing. Must be called once, after the last
  /// read.
  bool damaged_at_end();
  /// Returns true when the compressed data read so far is damaged. A missing end of the stream is not detected.
  bool damaged() const { return damaged_; }
  bool is_compressed() const { return compression_ != Compression::None; }
  /// Returns an upper bound of the number of decompressed bytes after the offset. Deflate expands a byte to at most
  /// 1032 bytes; a bzip2 block has at least 30 bytes and expands to at most 46 MB.
  double max_bytes() const;

 private:
  struct Stream;
  void open(const std::filesystem::path& path, Compression compression, std::uint64_t offset);
  bool fill();
  std::size_t read_file(void* to, std::size_t bytes);
  std::size_t read_deflate(void* to, std::size_t bytes);
  std::size_t read_bzip2(void* to, std::size_t bytes);

  int descriptor_ = -1;
  std::uint64_t begin_ = 0, next_ = 0;  ///< offsets in the file of the data and of the next uncompressed byte
  std::uint64_t file_bytes_ = 0;        ///< size of the file, bytes
  Compression compression_ = Compression::None;
  bool damaged_ = false, ended_ = false;
  std::unique_ptr<Stream> stream_;
};

}  // namespace simplexseg
