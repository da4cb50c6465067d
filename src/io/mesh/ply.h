// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Bytes of a PLY file: binary, little-endian, with polygonal faces and the neighbours of each vertex.
std::string ply_of(const SimplexMesh& mesh);
/// Reads a mesh from the bytes of a PLY file; the caller must validate() the mesh. `name`: file name in messages.
/// Throws Error if the file is damaged, its coordinates are in an unknown system, its faces disagree with the
/// neighbours of the vertices, or simplex_mesh_of() rejects its surface.
SimplexMesh mesh_of_ply(const std::string& bytes, const std::string& name);

}  // namespace simplexseg
