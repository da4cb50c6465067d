// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <cstring>
#include <ranges>

namespace simplexseg {

/// First index in [first, end) at which a list of bytes has this value, or `end`.
template <std::ranges::contiguous_range Bytes>
int find_value(const Bytes& values, std::ranges::range_value_t<Bytes> value, int first, int end) {
  static_assert(sizeof(value) == 1);
  const auto* const bytes = std::ranges::data(values);
  const void* const at = std::memchr(bytes + first, static_cast<int>(value), end - first);
  return at ? static_cast<int>(static_cast<decltype(bytes)>(at) - bytes) : end;
}

/// First index in [first, end) at which a list of bytes has another value, or `end`.
template <std::ranges::contiguous_range Bytes>
int find_other(const Bytes& values, std::ranges::range_value_t<Bytes> value, int first, int end) {
  static_assert(sizeof(value) == 1);
  const auto* const bytes = std::ranges::data(values);
  std::uint64_t alike, eight;
  std::memset(&alike, static_cast<int>(value), sizeof alike);
  while (first + 8 <= end && (std::memcpy(&eight, bytes + first, sizeof eight), eight == alike)) first += 8;
  while (first < end && bytes[first] == value) ++first;
  return first;
}

}  // namespace simplexseg
