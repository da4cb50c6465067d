// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "core/colour.h"

namespace simplexseg {

class JsonInput;

/// Text of a colour in scenes and label presets, for example "#e6a03c".
std::string colour_text(const Colour& colour);
/// Reads the text of colour_text(). Throws Error for another text.
Colour read_colour_text(const JsonInput& input);
/// Reads [red, green, blue], as in logs. Throws Error for other values.
Colour colour_from_json(const JsonInput& input);

}  // namespace simplexseg
