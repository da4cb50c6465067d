// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Bytes of a PLY file: binary, little-endian, with polygonal cells and the neighbours of each vertex.
std::string ply_of(const SimplexMesh& mesh);
/// Mesh from the bytes of a PLY file; the caller validates it. `name`: file name in messages. Throws Error if the file
/// is damaged or not in LPS, its polygons disagree with the neighbours, or simplex_mesh_of() rejects its surface.
SimplexMesh mesh_of_ply(const std::string& bytes, const std::string& name);

}  // namespace simplexseg
