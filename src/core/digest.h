// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace simplexseg {

/// 64-bit digest of values, FNV-1a (G. Fowler, L. Noll, K. Vo). Detects changes; not for untrusted data.
class Digest {
 public:
  /// Adds the bytes of `count` values, which must have no padding.
  template <class T>
  void add(const T* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* bytes = reinterpret_cast<const unsigned char*>(values);
    for (std::size_t b = 0; b < count * sizeof(T); ++b) value_ = (value_ ^ bytes[b]) * 0x100000001b3u;
  }
  template <class T>
  void add(const T& value) {
    add(&value, 1);
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

}  // namespace simplexseg
