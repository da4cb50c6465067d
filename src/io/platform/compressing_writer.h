// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>

namespace simplexseg {

class AtomicFile;

/// Writer that compresses bytes by deflate.
class CompressingWriter {
 public:
  enum class Frame { Gzip, Zlib };  ///< container: header and checksum of the deflate stream

  /// `file` must outlive the writer.
  CompressingWriter(AtomicFile& file, Frame frame);
  ~CompressingWriter();
  CompressingWriter(const CompressingWriter&) = delete;
  CompressingWriter& operator=(const CompressingWriter&) = delete;

  /// Throws Error when the file cannot be written.
  void write(const void* data, std::size_t bytes);
  /// Writes the end of the stream and returns the total number of compressed bytes. Call it once, after the last
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
