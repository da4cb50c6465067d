// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Contents of a PLY file, as bytes.
std::string ply_of(const SimplexMesh& mesh);
/// Mesh from the bytes of a PLY file, not validated; `name`: file name in messages. Throws Error for a damaged file.
SimplexMesh mesh_of_ply(const std::string& bytes, const std::string& name);

}  // namespace simplexseg
