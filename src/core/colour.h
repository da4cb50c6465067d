// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

namespace simplexseg {

struct Colour {
  std::uint8_t red, green, blue;
  bool operator==(const Colour&) const = default;
};

}  // namespace simplexseg
