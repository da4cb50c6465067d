// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "image/contrast_range.h"

namespace simplexseg {

/// Usual CT window width and level of a body region, in Hounsfield units.
struct ContrastPreset {
  const char* title;
  double window, level;
};
std::span<const ContrastPreset> contrast_presets();

}  // namespace simplexseg
