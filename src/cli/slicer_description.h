// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace simplexseg {

/// What 3D Slicer, and others that know the Slicer Execution Model, make a module of: the XML that describes the
/// options of `segment`.
std::string slicer_description();

}  // namespace simplexseg
