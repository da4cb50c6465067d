// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "core/colour.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Surface of an object in a file that holds several objects.
struct NamedSurface {
  std::string name;  ///< UTF-8
  Colour colour{230, 160, 60};
  const SimplexMesh* mesh = nullptr;
};

}  // namespace simplexseg
