// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Whether the extension is that of a mesh.
bool is_mesh_name(const std::filesystem::path& path);
/// Throws Error where write_mesh() would for the extension.
void require_mesh_name(const std::filesystem::path& path);

/// Writes a mesh by extension, positions in LPS and mm, as the file's comment says; written beside and renamed:
/// .ply binary, polygonal cells, positions bit for bit, neighbours as vertex properties n1 n2 n3: read_mesh's format;
/// .obj polygonal cells; .stl binary, tessellated; .vtk (legacy, binary) and .vtp polydata with polygonal cells.
/// Throws Error for another extension, a mesh that is not valid, a folder that does not exist, or a failed write.
void write_mesh(const std::filesystem::path& path, const SimplexMesh& mesh);

/// Reads a .ply whose polygons are the cells of a simplex mesh. The neighbours are those written (n1 n2 n3); without
/// them they are found from the polygons, so the cyclic start of each triple may differ. Throws Error when the file is
/// missing, truncated or not PLY, its polygons disagree with the neighbours, or the mesh is not valid (see validate()).
SimplexMesh read_mesh(const std::filesystem::path& path);

}  // namespace simplexseg
