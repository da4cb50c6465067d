// SPDX-License-Identifier: Apache-2.0
// Options that choose labels, shared by `mesh` and `compare`.
#pragma once
#include <string>

#include "io/labels/label_mesh.h"

namespace simplexseg {

inline constexpr const char* kThresholdHelp =
    "Smallest value that counts as labelled in a volume of fractions, for example a probability map; default: "
    "fractions are refused";

/// Returns the choice of a label option: a number is a value, any other text is a name, an empty text chooses all
/// labels. Throws Error for a number that is not finite.
LabelChoice label_choice(const std::string& text);

}  // namespace simplexseg
