// SPDX-License-Identifier: Apache-2.0
#include "remote/blosc_chunk.h"

#include <lz4.h>
#include <zstd.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "core/error.h"
#include "core/expect.h"
#include "remote/byte_order.h"

namespace simplexseg {
namespace {

constexpr std::size_t kHeader = 16, kExtendedHeader = 32, kFilters = 6;
constexpr std::size_t kBlock = std::size_t{1} << 18;  ///< uncompressed size of a written block, bytes
constexpr int kLevel = 3;                             ///< of Zstandard
constexpr std::uint8_t kVersion1 = 2, kLatestVersion = 5;

// Bits of the flags in the header. Both shuffles together: the header is the extended one of version 2.
constexpr unsigned kByteShuffle = 0x01, kUncompressed = 0x02, kBitShuffle = 0x04, kDelta = 0x08, kOneStream = 0x10;
constexpr unsigned kExtended = kByteShuffle | kBitShuffle;
constexpr unsigned kLz4 = 1, kZstandard = 4;  // bits 5 to 7

enum Filter : std::uint8_t { kNone = 0, kShuffleBytes = 1, kShuffleBits = 2, kFilterDelta = 3, kRoundedValues = 4 };
enum Special : unsigned { kNoSpecial = 0, kZeros = 1, kOneValue = 3 };

[[noreturn]] void damaged(const std::string& why) {
  throw Error("a compressed array", "it is damaged: " + why, "send it again");
}
[[noreturn]] void unsupported(const std::string& what) {
  throw Error("a compressed array", what + " is not supported", "use LZ4 or Zstandard, with or without shuffle");
}

struct Header {
  std::size_t length = kHeader;
  unsigned flags = 0;
  std::size_t element = 1, size = 0, block = 1, stored = 0;
  std::uint8_t filter = kNone;
  unsigned special = kNoSpecial;
};

std::size_t positive(std::string_view chunk, std::size_t at, const char* what) {
  const auto value = little_endian<std::int32_t>(chunk, at);
  if (value < 0) damaged(std::string(what) + " is negative");
  return static_cast<std::size_t>(value);
}

/// Reads the only filter that changes bytes on reading. Rounded values stay as they are.
std::uint8_t read_filter(std::string_view chunk) {
  std::uint8_t filter = kNone;
  for (std::size_t f = 0; f < kFilters; ++f) {
    const auto code = little_endian<std::uint8_t>(chunk, kHeader + f);
    if (code == kNone || code == kRoundedValues) continue;
    const auto meta = little_endian<std::uint8_t>(chunk, kHeader + 8 + f);
    if ((code != kShuffleBytes && code != kShuffleBits) || meta != 0 || filter != kNone)
      unsupported("its filter " + std::to_string(code));
    filter = code;
  }
  return filter;
}

Header read_header(std::string_view chunk) {
  if (chunk.size() < kHeader) damaged("its header is incomplete");
  Header header;
  const auto version = little_endian<std::uint8_t>(chunk, 0);
  if (version < kVersion1 || version > kLatestVersion) unsupported("version " + std::to_string(version) + " of Blosc");
  header.flags = little_endian<std::uint8_t>(chunk, 2);
  header.element = little_endian<std::uint8_t>(chunk, 3);
  header.size = positive(chunk, 4, "its size");
  header.block = positive(chunk, 8, "the size of its blocks");
  header.stored = positive(chunk, 12, "its compressed size");
  if (header.stored != chunk.size()) damaged("its length is not that of its header");
  if (header.element == 0) damaged("its elements have no bytes");
  if (header.size > 0 && (header.block == 0 || header.block > header.size)) damaged("its blocks have no valid size");
  if ((header.flags & kExtended) != kExtended) {
    if (header.flags & kDelta) unsupported("its delta filter");
    header.filter = header.flags & kByteShuffle ? kShuffleBytes : header.flags & kBitShuffle ? kShuffleBits : kNone;
    return header;
  }
  if (chunk.size() < kExtendedHeader) damaged("its header is incomplete");
  header.length = kExtendedHeader;
  header.filter = read_filter(chunk);
  const auto more = little_endian<std::uint8_t>(chunk, kExtendedHeader - 1);
  header.special = more >> 4 & 7u;
  if (more & 0x0fu) unsupported("a chunk with a dictionary, a longer header or another byte order");
  if (header.special != kNoSpecial && header.special != kZeros && header.special != kOneValue)
    unsupported("a chunk without values");
  return header;
}

/// Decompresses one stream.
void decompress(unsigned codec, std::string_view from, std::span<std::byte> to) {
  std::size_t size = std::numeric_limits<std::size_t>::max();
  if (codec == kZstandard) {
    size = ZSTD_decompress(to.data(), to.size(), from.data(), from.size());  // an error is larger than any size
  } else if (codec == kLz4) {
    const int count = LZ4_decompress_safe(from.data(), reinterpret_cast<char*>(to.data()),
                                          static_cast<int>(from.size()), static_cast<int>(to.size()));
    if (count >= 0) size = static_cast<std::size_t>(count);
  } else {
    unsupported("its codec " + std::to_string(codec));
  }
  if (size != to.size()) damaged("a block cannot be decompressed");
}

/// Reads a stream of a block and removes it from the beginning of `from`.
void read_stream(unsigned codec, std::string_view& from, std::span<std::byte> to) {
  if (from.size() < 4) damaged("a block is incomplete");
  const auto length = little_endian<std::int32_t>(from, 0);
  from.remove_prefix(4);
  if (length == 0) return std::fill(to.begin(), to.end(), std::byte{0});
  if (length < 0) {  // a run of one byte
    if (from.empty() || (static_cast<unsigned char>(from.front()) & 1) == 0 || length < -255)
      damaged("a block has an unknown encoding");
    from.remove_prefix(1);
    return std::fill(to.begin(), to.end(), static_cast<std::byte>(-length));
  }
  const auto bytes = static_cast<std::size_t>(length);
  if (bytes > from.size()) damaged("a block is incomplete");
  if (bytes == to.size())
    std::memcpy(to.data(), from.data(), bytes);
  else
    decompress(codec, from.substr(0, bytes), to);
  from.remove_prefix(bytes);
}

/// Sorts bytes by their place in the elements; the rest after the last element stays.
void shuffle(std::span<const std::byte> from, std::size_t element, std::byte* to) {
  const std::size_t count = from.size() / element, whole = count * element;
  for (std::size_t b = 0; b < element; ++b)
    for (std::size_t n = 0; n < count; ++n) to[b * count + n] = from[n * element + b];
  std::copy(from.begin() + static_cast<std::ptrdiff_t>(whole), from.end(), to + whole);
}
void unshuffle(std::span<const std::byte> from, std::size_t element, std::byte* to) {
  const std::size_t count = from.size() / element, whole = count * element;
  for (std::size_t b = 0; b < element; ++b)
    for (std::size_t n = 0; n < count; ++n) to[n * element + b] = from[b * count + n];
  std::copy(from.begin() + static_cast<std::ptrdiff_t>(whole), from.end(), to + whole);
}

/// Inverse of the bit shuffle of eight elements at a time. Version 1 leaves a block that has a rest unshuffled,
/// version 2 the rest only.
void unshuffle_bits(std::span<const std::byte> from, std::size_t element, bool version_1, std::byte* to) {
  std::size_t count = from.size() / element;
  count = version_1 && count % 8 != 0 ? 0 : count - count % 8;
  const std::size_t whole = count * element;
  std::fill_n(to, whole, std::byte{0});
  for (std::size_t bit = 0; bit < 8 * element; ++bit) {
    const std::byte* const row = from.data() + bit * (count / 8);
    const std::byte mask{static_cast<unsigned char>(1u << (bit % 8))};
    for (std::size_t n = 0; n < count; ++n)
      if ((row[n / 8] >> (n % 8) & std::byte{1}) != std::byte{0}) to[n * element + bit / 8] |= mask;
  }
  std::copy(from.begin() + static_cast<std::ptrdiff_t>(whole), from.end(), to + whole);
}

void read_one_value(std::string_view chunk, const Header& header, std::span<std::byte> to) {
  if (header.special == kZeros) return std::fill(to.begin(), to.end(), std::byte{0});
  if (chunk.size() < header.length + header.element || header.size % header.element != 0) damaged("it has no value");
  for (std::size_t n = 0; n < to.size(); n += header.element)
    std::memcpy(to.data() + n, chunk.data() + header.length, header.element);
}

void read_blocks(std::string_view chunk, const Header& header, std::span<std::byte> to) {
  const std::size_t blocks = (header.size + header.block - 1) / header.block;
  if (chunk.size() < header.length + 4 * blocks) damaged("the list of its blocks is incomplete");
  std::vector<std::byte> shuffled(header.filter == kNone ? 0 : header.block);
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::size_t start = positive(chunk, header.length + 4 * b, "the place of a block");
    if (start < header.length + 4 * blocks || start >= chunk.size()) damaged("a block lies outside");
    std::string_view from = chunk.substr(start);
    const std::span<std::byte> block =
        to.subspan(b * header.block, std::min(header.block, to.size() - b * header.block));
    const std::span<std::byte> raw = shuffled.empty() ? block : std::span(shuffled).first(block.size());
    const bool split = (header.flags & kOneStream) == 0 && block.size() == header.block;
    const std::size_t streams = split ? header.element : 1, length = block.size() / streams;
    if (length == 0 || length * streams != block.size()) damaged("its blocks cannot be split");
    for (std::size_t s = 0; s < streams; ++s) read_stream(header.flags >> 5, from, raw.subspan(s * length, length));
    if (header.filter == kShuffleBytes) unshuffle(raw, header.element, block.data());
    if (header.filter == kShuffleBits)
      unshuffle_bits(raw, header.element, little_endian<std::uint8_t>(chunk, 0) == kVersion1, block.data());
  }
}

}  // namespace

std::string blosc_chunk(std::span<const std::byte> bytes, int element_bytes) {
  SIMPLEXSEG_EXPECT(bytes.size() <= kMaxChunkBytes && element_bytes >= 1 && element_bytes <= 16);
  const auto element = static_cast<std::size_t>(element_bytes);
  const std::size_t block = std::max<std::size_t>(std::min(kBlock, bytes.size()), 1);
  const std::size_t blocks = (bytes.size() + block - 1) / block;
  std::string chunk(kHeader + 4 * blocks, '\0');
  std::vector<std::byte> shuffled(element > 1 ? block : 0);
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), &ZSTD_freeCCtx);
  if (!context) throw Error("an array", "there is no memory to compress it", "close other programs");
  for (std::size_t b = 0; b < blocks; ++b) {
    std::span<const std::byte> raw = bytes.subspan(b * block, std::min(block, bytes.size() - b * block));
    if (element > 1) {
      shuffle(raw, element, shuffled.data());
      raw = std::span<const std::byte>(shuffled).first(raw.size());
    }
    const std::size_t start = chunk.size();
    set_little_endian(chunk, kHeader + 4 * b, static_cast<std::int32_t>(start));
    chunk.resize(start + 4 + raw.size());
    // A block that does not become smaller is stored as it is; its length shows that.
    const std::size_t room = raw.size() - 1;
    std::size_t length =
        ZSTD_compressCCtx(context.get(), chunk.data() + start + 4, room, raw.data(), raw.size(), kLevel);
    if (ZSTD_isError(length)) {
      length = raw.size();
      std::memcpy(chunk.data() + start + 4, raw.data(), raw.size());
    }
    set_little_endian(chunk, start, static_cast<std::int32_t>(length));
    chunk.resize(start + 4 + length);
  }
  chunk[0] = static_cast<char>(kVersion1), chunk[1] = 1;
  chunk[2] = static_cast<char>(kZstandard << 5 | kOneStream | (element > 1 ? kByteShuffle : 0));
  chunk[3] = static_cast<char>(element);
  set_little_endian(chunk, 4, static_cast<std::int32_t>(bytes.size()));
  set_little_endian(chunk, 8, static_cast<std::int32_t>(block));
  set_little_endian(chunk, 12, static_cast<std::int32_t>(chunk.size()));
  return chunk;
}

void read_blosc_chunk(std::string_view chunk, std::span<std::byte> to) {
  const Header header = read_header(chunk);
  if (header.size != to.size()) damaged("its size is not the expected one");
  if (to.empty()) return;
  if (header.special != kNoSpecial) return read_one_value(chunk, header, to);
  if (header.flags & kUncompressed) {
    if (chunk.size() != header.length + header.size) damaged("its length is not that of its header");
    std::memcpy(to.data(), chunk.data() + header.length, to.size());
    return;
  }
  read_blocks(chunk, header, to);
}

}  // namespace simplexseg
