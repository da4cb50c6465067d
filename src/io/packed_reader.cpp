// SPDX-License-Identifier: Apache-2.0
#include "io/packed_reader.h"

#include <bzlib.h>
#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "io/files.h"

namespace simplexseg {

namespace {

constexpr std::size_t kBlock = 1 << 18;
constexpr std::size_t kMostAtOnce = 1 << 30;  // both libraries count in unsigned int
constexpr int kGzipOrZlib = 32 + MAX_WBITS;

Packing packing_of(const std::filesystem::path& path) {
  std::array<unsigned char, 2> magic{};
  PackedReader plain(path, Packing::None);
  const bool gzip = plain.read(magic.data(), 2) == 2 && magic[0] == 0x1f && magic[1] == 0x8b;
  return gzip ? Packing::Deflate : Packing::None;
}

}  // namespace

/// The packed bytes that are next, and the library's state.
struct PackedReader::Stream {
  explicit Stream(Packing used) : packing(used) {
    const bool made =
        packing == Packing::Deflate ? inflateInit2(&z, kGzipOrZlib) == Z_OK : BZ2_bzDecompressInit(&bz, 0, 0) == BZ_OK;
    if (!made) throw std::bad_alloc();
  }
  ~Stream() { packing == Packing::Deflate ? inflateEnd(&z) : BZ2_bzDecompressEnd(&bz); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  Packing packing;
  z_stream z{};
  bz_stream bz{};
  std::array<unsigned char, kBlock> packed;
  std::size_t first = 0, last = 0;  ///< of `packed`: what is not unpacked yet
};

PackedReader::PackedReader(const std::filesystem::path& path) { open(path, packing_of(path), 0); }

PackedReader::PackedReader(const std::filesystem::path& path, Packing packing, std::uint64_t offset) {
  open(path, packing, offset);
}

void PackedReader::open(const std::filesystem::path& path, Packing packing, std::uint64_t offset) {
  require_file(path);
  packing_ = packing;
  begin_ = next_ = offset;
  file_bytes_ = std::filesystem::file_size(path);
  if (packing != Packing::None) stream_ = std::make_unique<Stream>(packing);
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0) throw Error("cannot read " + quoted(path), std::strerror(errno), "check its permissions");
  if (packing != Packing::None) ::lseek(descriptor_, static_cast<off_t>(std::min(begin_, file_bytes_)), SEEK_SET);
}

PackedReader::~PackedReader() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::size_t PackedReader::read_file(void* to, std::size_t bytes) {
  std::size_t done = 0;
  while (done < bytes) {
    const std::size_t wanted = std::min(bytes - done, kMostAtOnce);
    const ssize_t got = ::read(descriptor_, static_cast<char*>(to) + done, wanted);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

/// Brings packed bytes where none are left; false at the end of the file.
bool PackedReader::fill() {
  Stream& s = *stream_;
  if (s.first == s.last) s.first = 0, s.last = read_file(s.packed.data(), s.packed.size());
  return s.first < s.last;
}

std::size_t PackedReader::inflate_some(void* to, std::size_t bytes) {
  Stream& s = *stream_;
  s.z.next_in = s.packed.data() + s.first;
  s.z.avail_in = static_cast<uInt>(s.last - s.first);
  s.z.next_out = static_cast<unsigned char*>(to);
  s.z.avail_out = static_cast<uInt>(bytes);
  const int result = inflate(&s.z, Z_NO_FLUSH);
  s.first = s.last - s.z.avail_in;
  if (result == Z_STREAM_END) {  // files may be put one behind the other; what else follows is not looked at
    ended_ = !fill() || s.packed[s.first] != 0x1f || inflateReset2(&s.z, kGzipOrZlib) != Z_OK;
  } else if (result != Z_OK && result != Z_BUF_ERROR) {
    damaged_ = true;
  }
  return bytes - s.z.avail_out;
}

std::size_t PackedReader::bunzip_some(void* to, std::size_t bytes) {
  Stream& s = *stream_;
  s.bz.next_in = reinterpret_cast<char*>(s.packed.data() + s.first);
  s.bz.avail_in = static_cast<unsigned>(s.last - s.first);
  s.bz.next_out = static_cast<char*>(to);
  s.bz.avail_out = static_cast<unsigned>(bytes);
  const int result = BZ2_bzDecompress(&s.bz);
  s.first = s.last - s.bz.avail_in;
  const std::size_t done = bytes - s.bz.avail_out;
  if (result == BZ_STREAM_END) {
    ended_ = true;
    if (fill() && s.packed[s.first] == 'B') {  // packed in parts by several threads
      BZ2_bzDecompressEnd(&s.bz);
      s.bz = {};
      ended_ = BZ2_bzDecompressInit(&s.bz, 0, 0) != BZ_OK;
    }
  } else if (result != BZ_OK) {
    damaged_ = true;
  }
  return done;
}

std::size_t PackedReader::read(void* to, std::size_t bytes) {
  if (!packed()) {
    std::size_t done = 0;
    while (done < bytes) {
      const std::size_t wanted = std::min(bytes - done, kMostAtOnce);
      const ssize_t got = ::pread(descriptor_, static_cast<char*>(to) + done, wanted, static_cast<off_t>(next_ + done));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) break;
      done += static_cast<std::size_t>(got);
    }
    next_ += done;
    return done;
  }
  std::size_t done = 0;
  while (done < bytes && !damaged_ && !ended_) {
    // Bytes may still lie in the library's own window when the file is at its end.
    const bool more = fill();
    const std::size_t wanted = std::min(bytes - done, kMostAtOnce);
    char* const at = static_cast<char*>(to) + done;
    const std::size_t got = packing_ == Packing::Deflate ? inflate_some(at, wanted) : bunzip_some(at, wanted);
    done += got;
    if (!more && got == 0) break;
  }
  return done;
}

bool PackedReader::skip(std::uint64_t bytes) {
  if (!packed()) {
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

bool PackedReader::damaged_at_end() {
  if (!packed()) return false;
  char byte;
  const bool more = read(&byte, 1) == 1;  // makes the library look at the checksum
  return damaged_ || (!more && !ended_);
}

double PackedReader::most_bytes() const {
  const double bytes = begin_ < file_bytes_ ? static_cast<double>(file_bytes_ - begin_) : 0;
  if (packing_ == Packing::Deflate) return 1032 * bytes;
  if (packing_ == Packing::Bzip2) return (bytes / 30 + 1) * 46e6;
  return bytes;
}

}  // namespace simplexseg
