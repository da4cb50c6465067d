// SPDX-License-Identifier: Apache-2.0
// Validation of CBOR (RFC 8949).
#include "io/platform/cbor.h"

#include <cstdint>
#include <stdexcept>
#include <vector>

namespace simplexseg {
namespace {

constexpr std::size_t kMaxDepth = 16;
enum Major { kBytes = 2, kText = 3, kArray = 4, kMap = 5, kTag = 6 };

}  // namespace

void expect_plain_cbor(const std::string& bytes, std::size_t max_items) {
  std::size_t at = 0, items = 0;
  const auto next = [&]() -> std::uint64_t {
    if (at == bytes.size()) throw std::out_of_range("it is truncated");
    return static_cast<unsigned char>(bytes[at++]);
  };
  std::vector<std::uint64_t> open;  // number of items still expected in each open array or map
  do {
    if (++items > max_items) throw std::out_of_range("it has too many items");
    const std::uint64_t head = next();
    const std::uint64_t major = head >> 5;
    std::uint64_t value = head & 31;
    if (value > 27 || major == kTag) throw std::out_of_range("it contains items of an unsupported kind");
    if (value >= 24) {
      const int length = 1 << (value - 24);
      value = 0;
      for (int byte = 0; byte < length; ++byte) value = value << 8 | next();
    }
    const std::size_t left = bytes.size() - at;
    if (major >= kBytes && major <= kMap && value > left) throw std::out_of_range("it is truncated");
    if (major == kBytes || major == kText) at += value;
    if ((major == kArray || major == kMap) && value > 0) {
      if (open.size() == kMaxDepth) throw std::out_of_range("its lists are nested too deeply");
      open.push_back(major == kMap ? 2 * value : value);
      continue;
    }
    while (!open.empty() && --open.back() == 0) open.pop_back();
  } while (!open.empty());
  if (at != bytes.size()) throw std::out_of_range("data follows its end");
}

}  // namespace simplexseg
