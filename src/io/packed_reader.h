// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

namespace simplexseg {

enum class Packing : std::uint8_t { None, Deflate, Bzip2 };  ///< Deflate: within gzip or zlib, told by the first bytes

/// A file read from a place on, unpacked on the way.
class PackedReader {
 public:
  /// From its start; unpacked when its first bytes are gzip's, whatever its name. Throws Error when the file is
  /// missing, empty or cannot be opened.
  explicit PackedReader(const std::filesystem::path& path);
  /// From byte `offset` of the file on. Throws Error as above.
  PackedReader(const std::filesystem::path& path, Packing packing, std::uint64_t offset = 0);
  ~PackedReader();
  PackedReader(const PackedReader&) = delete;
  PackedReader& operator=(const PackedReader&) = delete;

  /// Reads up to `bytes`; fewer at the end of the file, or where the packed stream is damaged (see damaged()).
  std::size_t read(void* to, std::size_t bytes);
  /// Skips `bytes`; false when the file ends before.
  bool skip(std::uint64_t bytes);
  /// To be called once all that was wanted is read: true when the stream's checksum is wrong or its end is missing.
  bool damaged_at_end();
  /// True when what was read so far met packed data that are wrong; false at a mere end of the file.
  bool damaged() const { return damaged_; }
  bool packed() const { return packing_ != Packing::None; }
  /// The most bytes that can come out of what follows the offset, whatever it is: its size, or the best that the
  /// packing can do (deflate 1032 bytes for one; bzip2 46 MB for a block, which takes 30 bytes at least).
  double most_bytes() const;

 private:
  struct Stream;
  void open(const std::filesystem::path& path, Packing packing, std::uint64_t offset);
  bool fill();
  std::size_t read_file(void* to, std::size_t bytes);
  std::size_t inflate_some(void* to, std::size_t bytes);
  std::size_t bunzip_some(void* to, std::size_t bytes);

  int descriptor_ = -1;
  std::uint64_t begin_ = 0, next_ = 0, file_bytes_ = 0;  ///< places in the file; `next_` where it is not packed
  Packing packing_ = Packing::None;
  bool damaged_ = false, ended_ = false;
  std::unique_ptr<Stream> stream_;
};

}  // namespace simplexseg
