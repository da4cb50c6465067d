// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace simplexseg {

/// Returns the XML description of the options of `segment`, from which 3D Slicer and other programs that support the
/// Slicer Execution Model create a module.
std::string slicer_description();

}  // namespace simplexseg
