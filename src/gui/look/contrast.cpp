// SPDX-License-Identifier: Apache-2.0
#include "gui/look/contrast.h"

namespace simplexseg {

std::span<const ContrastPreset> contrast_presets() {
  static constexpr ContrastPreset kPresets[] = {{"CT soft tissue", 400, 40},
                                                {"CT liver", 150, 60},
                                                {"CT lung", 1500, -600},
                                                {"CT bone", 1800, 400},
                                                {"CT brain", 80, 40}};
  return kPresets;
}

}  // namespace simplexseg
