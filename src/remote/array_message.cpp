// SPDX-License-Identifier: Apache-2.0
#include "remote/array_message.h"

#include <algorithm>
#include <array>
#include <new>

#include "core/error.h"
#include "core/expect.h"
#include "io/platform/bytes.h"
#include "io/platform/files.h"
#include "io/platform/load_progress.h"
#include "remote/blosc_chunk.h"
#include "remote/byte_order.h"

namespace simplexseg {
namespace {

// Layout: "NNIA", version, codec, number of axes, length of the type's name, the name, the sizes of the axes (int64),
// the number of chunks (uint32); then for each chunk its uncompressed and its compressed length (uint64 each) and the
// chunk. All numbers are little-endian.
constexpr std::string_view kMagic = "NNIA";
constexpr std::uint8_t kVersion = 1, kCodecZstandard = 1, kCodecLz4 = 2;
constexpr std::size_t kStart = 8, kMaxAxes = 8;
constexpr std::size_t kWrittenChunk = std::size_t{1} << 24;  ///< small, so that a cancellation takes effect soon

struct TypeInfo {
  const char* name;
  std::size_t bytes;
};
constexpr std::array<TypeInfo, 10> kTypes = {{{"bool", 1},
                                              {"int8", 1},
                                              {"uint8", 1},
                                              {"int16", 2},
                                              {"uint16", 2},
                                              {"int32", 4},
                                              {"uint32", 4},
                                              {"float16", 2},
                                              {"float32", 4},
                                              {"float64", 8}}};

Error bad_array(const std::string& why, const std::string& what_to_do = "send it again") {
  return Error("an array of a message", why, what_to_do);
}

/// Reader of a message from its beginning to its end.
struct Rest {
  std::string_view bytes;

  std::string_view take(std::uint64_t count) {
    if (count > bytes.size()) throw bad_array("it is incomplete");
    const std::string_view taken = bytes.substr(0, static_cast<std::size_t>(count));
    bytes.remove_prefix(taken.size());
    return taken;
  }
  template <class T>
  T number() {
    return little_endian<T>(take(sizeof(T)), 0);
  }
};

}  // namespace

std::size_t bytes_of(ArrayType type) { return kTypes[static_cast<std::size_t>(type)].bytes; }
const char* name_of(ArrayType type) { return kTypes[static_cast<std::size_t>(type)].name; }

std::string pack_array(ArrayType type, std::span<const std::int64_t> shape, std::span<const std::byte> bytes) {
  std::size_t expected = bytes_of(type);
  for (const std::int64_t size : shape) expected *= static_cast<std::size_t>(size);
  SIMPLEXSEG_EXPECT(shape.size() <= kMaxAxes && expected == bytes.size());
  const std::string_view name = name_of(type);
  std::string message(kMagic);
  for (const std::size_t one : {std::size_t{kVersion}, std::size_t{kCodecZstandard}, shape.size(), name.size()})
    append(message, static_cast<std::uint8_t>(one));
  message += name;
  for (const std::int64_t size : shape) append(message, size);
  append(message, static_cast<std::uint32_t>((bytes.size() + kWrittenChunk - 1) / kWrittenChunk));
  for (std::size_t start = 0; start < bytes.size(); start += kWrittenChunk) {
    report_progress(static_cast<double>(start), static_cast<double>(bytes.size()));
    const std::span<const std::byte> part = bytes.subspan(start, std::min(kWrittenChunk, bytes.size() - start));
    const std::string chunk = blosc_chunk(part, static_cast<int>(bytes_of(type)));
    append(message, static_cast<std::uint64_t>(part.size()));
    append(message, static_cast<std::uint64_t>(chunk.size()));
    message += chunk;
  }
  return message;
}

ArrayMessage unpack_array(std::string_view message, std::uint64_t max_bytes) {
  Rest rest{message};
  const std::string_view start = rest.take(kStart);
  if (!start.starts_with(kMagic)) throw bad_array("it does not begin with NNIA", "check the address of the server");
  if (const auto version = little_endian<std::uint8_t>(start, 4); version != kVersion)
    throw bad_array("its version " + std::to_string(version) + " is unknown", "update this program or the other one");
  if (const auto codec = little_endian<std::uint8_t>(start, 5); codec != kCodecZstandard && codec != kCodecLz4)
    throw bad_array("its codec " + std::to_string(codec) + " is unknown", "update this program or the other one");
  const std::size_t axes = little_endian<std::uint8_t>(start, 6);
  if (axes > kMaxAxes) throw bad_array("it has " + std::to_string(axes) + " axes", "use at most eight");
  const std::string_view name = rest.take(little_endian<std::uint8_t>(start, 7));
  const auto type = std::ranges::find(kTypes, name, &TypeInfo::name);
  if (type == kTypes.end())
    throw bad_array("its type '" + one_line(std::string(name), 40) + "' is unknown",
                    "use for example uint8 or float32");
  ArrayMessage array;
  array.type = static_cast<ArrayType>(type - kTypes.begin());
  std::uint64_t size = type->bytes;
  for (std::size_t a = 0; a < axes; ++a) {
    const auto length = rest.number<std::int64_t>();
    if (length < 0) throw bad_array("one of its axes has a negative size");
    array.shape.push_back(length);
    // A product of at most max_bytes / length times length does not overflow; 0 stays 0.
    if (length > 0 && size > max_bytes / static_cast<std::uint64_t>(length))
      throw bad_array("it is larger than " + format_bytes(static_cast<double>(max_bytes)), "use a smaller image");
    size *= static_cast<std::uint64_t>(length);
  }
  if (size > max_bytes)
    throw bad_array("it is larger than " + format_bytes(static_cast<double>(max_bytes)), "use a smaller image");
  const auto chunks = rest.number<std::uint32_t>();
  std::uint64_t claimed = 0;  // checks all lengths before the array is allocated
  Rest lengths = rest;
  for (std::uint32_t c = 0; c < chunks; ++c) {
    const auto length = lengths.number<std::uint64_t>();
    const auto stored = lengths.number<std::uint64_t>();
    lengths.take(stored);
    if (length > size - claimed) throw bad_array("its chunks are larger than its shape");
    claimed += length;
  }
  if (claimed != size) throw bad_array("its chunks are smaller than its shape");
  if (!lengths.bytes.empty()) throw bad_array("it continues after its last chunk");
  try {
    array.bytes.resize(static_cast<std::size_t>(size));
  } catch (const std::bad_alloc&) {
    throw bad_array("it needs " + format_bytes(static_cast<double>(size)) + " of memory", "close other programs");
  }
  std::size_t done = 0;
  for (std::uint32_t c = 0; c < chunks; ++c) {
    check_cancelled();
    const auto length = static_cast<std::size_t>(rest.number<std::uint64_t>());
    const auto stored = rest.number<std::uint64_t>();
    read_blosc_chunk(rest.take(stored), std::span(array.bytes).subspan(done, length));
    done += length;
  }
  return array;
}

}  // namespace simplexseg
