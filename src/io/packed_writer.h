// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>

namespace simplexseg {

class AtomicFile;

/// Packs bytes by deflate on their way into a file.
class PackedWriter {
 public:
  enum class Frame { Gzip, Zlib };  ///< which header and checksum stand around the packed bytes

  /// The file must outlive it.
  PackedWriter(AtomicFile& file, Frame frame);
  ~PackedWriter();
  PackedWriter(const PackedWriter&) = delete;
  PackedWriter& operator=(const PackedWriter&) = delete;

  /// Throws Error when the file cannot be written.
  void write(const void* data, std::size_t bytes);
  /// To be called once, after the last write(): what is still held goes to the file. Returns the packed bytes in all.
  /// Throws Error as write().
  std::uint64_t finish();

 private:
  struct Stream;
  void pack(int flush);

  AtomicFile& file_;
  std::unique_ptr<Stream> stream_;
  std::uint64_t written_ = 0;
};

}  // namespace simplexseg
