// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>

namespace simplexseg {

class AtomicFile;

/// Writer of deflate-compressed bytes.
class CompressingWriter {
 public:
  enum class Frame { Gzip, Zlib };  ///< container with header and checksum around the deflate stream

  /// Begins a stream at the end of `file`, which must outlive the writer. Throws Error when there is not enough memory.
  CompressingWriter(AtomicFile& file, Frame frame);
  ~CompressingWriter();
  CompressingWriter(const CompressingWriter&) = delete;
  CompressingWriter& operator=(const CompressingWriter&) = delete;

  /// Compresses and writes `bytes` bytes. Throws Error when the file cannot be written.
  void write(const void* data, std::size_t bytes);
  /// Writes the end of the stream and returns the total number of compressed bytes. Must be called once, after the last
  /// write(). Throws Error like write().
  std::uint64_t finish();

 private:
  struct Stream;
  void compress(int flush);

  AtomicFile& file_;
  std::unique_ptr<Stream> stream_;
  std::uint64_t written_ = 0;
};

}  // namespace simplexseg
