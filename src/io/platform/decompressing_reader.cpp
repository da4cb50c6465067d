// SPDX-License-Identifier: Apache-2.0
#include "io/platform/decompressing_reader.h"

#include <bzlib.h>
#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "core/system_error.h"
#include "io/platform/files.h"

namespace simplexseg {

namespace {

constexpr std::size_t kInputBlock = 1 << 18;
constexpr std::size_t kMaxAtOnce = 1 << 30;  // zlib and bzip2 count bytes in unsigned int
constexpr int kGzipOrZlib = 32 + MAX_WBITS;

Compression compression_of(const std::filesystem::path& path) {
  std::array<unsigned char, 2> magic{};
  DecompressingReader plain(path, Compression::None);
  const bool gzip = plain.read(magic.data(), 2) == 2 && magic[0] == 0x1f && magic[1] == 0x8b;
  return gzip ? Compression::Deflate : Compression::None;
}

}  // namespace

/// Buffer of compressed bytes and state of the decompression library.
struct DecompressingReader::Stream {
  explicit Stream(Compression used) : compression(used) {
    const bool made = compression == Compression::Deflate ? inflateInit2(&z, kGzipOrZlib) == Z_OK
                                                          : BZ2_bzDecompressInit(&bz, 0, 0) == BZ_OK;
    if (!made) throw std::bad_alloc();
  }
  ~Stream() { compression == Compression::Deflate ? inflateEnd(&z) : BZ2_bzDecompressEnd(&bz); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  Compression compression;
  z_stream z{};
  bz_stream bz{};
  std::array<unsigned char, kInputBlock> compressed;
  std::size_t first = 0, last = 0;  ///< range of `compressed` that is not yet decompressed
};

DecompressingReader::DecompressingReader(const std::filesystem::path& path) { open(path, compression_of(path), 0); }

DecompressingReader::DecompressingReader(const std::filesystem::path& path, Compression compression,
                                         std::uint64_t offset) {
  open(path, compression, offset);
}

void DecompressingReader::open(const std::filesystem::path& path, Compression compression, std::uint64_t offset) {
  require_file(path);
  compression_ = compression;
  begin_ = next_ = offset;
  file_bytes_ = std::filesystem::file_size(path);
  if (compression != Compression::None) stream_ = std::make_unique<Stream>(compression);
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0)
    throw Error("cannot read " + quoted(path), system_error_text(errno), "check the permissions of the file");
  if (compression != Compression::None)
    ::lseek(descriptor_, static_cast<off_t>(std::min(begin_, file_bytes_)), SEEK_SET);
}

DecompressingReader::~DecompressingReader() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::size_t DecompressingReader::read_file(void* to, std::size_t bytes) {
  std::size_t done = 0;
  while (done < bytes) {
    const std::size_t requested = std::min(bytes - done, kMaxAtOnce);
    const ssize_t got = ::read(descriptor_, static_cast<char*>(to) + done, requested);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

/// Refills the empty buffer with compressed bytes; returns false at the end of the file.
bool DecompressingReader::fill() {
  Stream& s = *stream_;
  if (s.first == s.last) s.first = 0, s.last = read_file(s.compressed.data(), s.compressed.size());
  return s.first < s.last;
}

std::size_t DecompressingReader::read_deflate(void* to, std::size_t bytes) {
  Stream& s = *stream_;
  s.z.next_in = s.compressed.data() + s.first;
  s.z.avail_in = static_cast<uInt>(s.last - s.first);
  s.z.next_out = static_cast<unsigned char*>(to);
  s.z.avail_out = static_cast<uInt>(bytes);
  const int result = inflate(&s.z, Z_NO_FLUSH);
  s.first = s.last - s.z.avail_in;
  if (result == Z_STREAM_END) {  // gzip members can be concatenated; other trailing data is ignored
    ended_ = !fill() || s.compressed[s.first] != 0x1f || inflateReset2(&s.z, kGzipOrZlib) != Z_OK;
  } else if (result != Z_OK && result != Z_BUF_ERROR) {
    damaged_ = true;
  }
  return bytes - s.z.avail_out;
}

std::size_t DecompressingReader::read_bzip2(void* to, std::size_t bytes) {
  Stream& s = *stream_;
  s.bz.next_in = reinterpret_cast<char*>(s.compressed.data() + s.first);
  s.bz.avail_in = static_cast<unsigned>(s.last - s.first);
  s.bz.next_out = static_cast<char*>(to);
  s.bz.avail_out = static_cast<unsigned>(bytes);
  const int result = BZ2_bzDecompress(&s.bz);
  s.first = s.last - s.bz.avail_in;
  const std::size_t done = bytes - s.bz.avail_out;
  if (result == BZ_STREAM_END) {
    ended_ = true;
    if (fill() && s.compressed[s.first] == 'B') {  // parallel compressors write several streams
      BZ2_bzDecompressEnd(&s.bz);
      s.bz = {};
      ended_ = BZ2_bzDecompressInit(&s.bz, 0, 0) != BZ_OK;
    }
  } else if (result != BZ_OK) {
    damaged_ = true;
  }
  return done;
}

std::size_t DecompressingReader::read(void* to, std::size_t bytes) {
  if (!is_compressed()) {
    std::size_t done = 0;
    while (done < bytes) {
      const std::size_t requested = std::min(bytes - done, kMaxAtOnce);
      const ssize_t got =
          ::pread(descriptor_, static_cast<char*>(to) + done, requested, static_cast<off_t>(next_ + done));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) break;
      done += static_cast<std::size_t>(got);
    }
    next_ += done;
    return done;
  }
  std::size_t done = 0;
  while (done < bytes && !damaged_ && !ended_) {
    // The library can still hold decompressed bytes at the end of the file.
    const bool more = fill();
    const std::size_t requested = std::min(bytes - done, kMaxAtOnce);
    char* const at = static_cast<char*>(to) + done;
    const std::size_t got =
        compression_ == Compression::Deflate ? read_deflate(at, requested) : read_bzip2(at, requested);
    done += got;
    if (!more && got == 0) break;
  }
  return done;
}

bool DecompressingReader::skip(std::uint64_t bytes) {
  if (!is_compressed()) {
    if (next_ > file_bytes_ || bytes > file_bytes_ - next_) return false;
    next_ += bytes;
    return true;
  }
  std::vector<char> block(static_cast<std::size_t>(std::min<std::uint64_t>(bytes, 1 << 16)));
  while (bytes > 0) {
    const auto chunk = static_cast<std::size_t>(std::min<std::uint64_t>(bytes, block.size()));
    if (read(block.data(), chunk) != chunk) return false;
    bytes -= chunk;
  }
  return true;
}

bool DecompressingReader::damaged_at_end() {
  if (!is_compressed()) return false;
  char byte;
  const bool more = read(&byte, 1) == 1;  // triggers the check of the checksum
  return damaged_ || (!more && !ended_);
}

double DecompressingReader::max_bytes() const {
  const double bytes = begin_ < file_bytes_ ? static_cast<double>(file_bytes_ - begin_) : 0;
  if (compression_ == Compression::Deflate) return 1032 * bytes;
  if (compression_ == Compression::Bzip2) return (bytes / 30 + 1) * 46e6;
  return bytes;
}

}  // namespace simplexseg
