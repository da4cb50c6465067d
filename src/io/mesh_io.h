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
/// .ply binary, polygonal cells, positions bit for bit, neighbours as vertex properties n1 n2 n3;
/// .obj polygonal cells; .stl binary, tessellated; .vtk (legacy, binary) and .vtp polydata with polygonal cells.
/// Throws Error for another extension, a mesh that is not valid, a folder that does not exist, or a failed write.
void write_mesh(const std::filesystem::path& path, const SimplexMesh& mesh);

/// Reads a mesh by extension, as written by write_mesh() or by another program, in mm and LPS (RAS where the file's
/// comments say SPACE=RAS, but of .ply, which is refused then). A .ply with neighbours n1 n2 n3 is a simplex mesh to
/// the bit; polygons of which each vertex has three are its cells; any other closed surface becomes its dual, with a
/// vertex for each triangle (simplex_mesh_of()). Throws Error when the file is missing, damaged or kept in a way that
/// is not read (surface_formats.h), its polygons disagree with the neighbours, the surface is open, not manifold or of
/// mixed sense, or the mesh is not valid (see validate()).
SimplexMesh read_mesh(const std::filesystem::path& path);

}  // namespace simplexseg
