// SPDX-License-Identifier: Apache-2.0
#include "io/scene/colour_text.h"

#include <charconv>
#include <cstdint>

#include "core/number_text.h"
#include "io/platform/files.h"
#include "io/scene/json_input.h"

namespace simplexseg {

std::string colour_text(const Colour& colour) {
  std::string text = "#";
  for (const std::uint8_t part : {colour.red, colour.green, colour.blue}) text += hexadecimal_text(part, 2);
  return text;
}

Colour read_colour_text(const JsonInput& input) {
  const std::string text = input.text();
  const bool hex =
      text.size() == 7 && text[0] == '#' && text.find_first_not_of("0123456789abcdefABCDEF", 1) == text.npos;
  if (!hex) input.fail("'" + one_line(text) + "' is not a colour", "write it as \"#e6a03c\"");
  const auto channel = [&text](int at) {
    unsigned value = 0;
    std::from_chars(text.data() + at, text.data() + at + 2, value, 16);
    return static_cast<std::uint8_t>(value);
  };
  return {channel(1), channel(3), channel(5)};
}

Colour colour_from_json(const JsonInput& input) {
  if (input.size() != 3) input.fail("a colour must have three numbers", "write [red, green, blue]");
  const auto channel = [&input](int c) { return static_cast<std::uint8_t>(input[c].integer_between(0, 255)); };
  return {channel(0), channel(1), channel(2)};
}

}  // namespace simplexseg
