// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

namespace simplexseg {

/// File of data/labels/, which CMake compiles into the program.
struct LabelPresetFile {
  const char* name;  ///< file name without extension
  const char* text;
};
std::span<const LabelPresetFile> label_preset_files();

}  // namespace simplexseg
