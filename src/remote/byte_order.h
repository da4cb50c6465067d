// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <bit>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>

namespace simplexseg {

static_assert(std::endian::native == std::endian::little, "numbers of messages are copied as they are in memory");

/// Number at a place of a message, which must contain all of it.
template <class T>
T little_endian(std::string_view bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}
/// Overwrites a number at a place of a message.
template <class T>
void set_little_endian(std::string& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

}  // namespace simplexseg
