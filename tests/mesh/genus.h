// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Sum of 1 - genus over all closed surfaces.
inline int one_less_genus(const SimplexMesh& mesh) {
  return (mesh.vertex_count() - 3 * mesh.vertex_count() / 2 + cells_of(mesh).count()) / 2;
}

}  // namespace simplexseg
