// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstring>
#include <ranges>

namespace simplexseg {

/// The first index from `first` to before `end` at which a list of bytes has this value, or `end`: many bytes at once.
template <std::ranges::contiguous_range Bytes>
int find_value(const Bytes& values, std::ranges::range_value_t<Bytes> value, int first, int end) {
  static_assert(sizeof(value) == 1);
  const auto* const bytes = std::ranges::data(values);
  const void* const at = std::memchr(bytes + first, static_cast<int>(value), end - first);
  return at ? static_cast<int>(static_cast<decltype(bytes)>(at) - bytes) : end;
}

}  // namespace simplexseg
