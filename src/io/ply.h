// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// The whole file as bytes.
std::string ply_of(const SimplexMesh& mesh);
/// Mesh of a PLY file's bytes, not yet validated; `name` is for messages.
SimplexMesh mesh_of_ply(const std::string& bytes, const std::string& name);

}  // namespace simplexseg
