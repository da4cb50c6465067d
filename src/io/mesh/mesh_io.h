// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <span>

#include "io/mesh/named_surface.h"

namespace simplexseg {

/// Whether the file name has the extension of a mesh format that read_mesh() supports.
bool is_mesh_name(const std::filesystem::path& path);
/// Whether the file name has the extension of a format that holds several surfaces: .3mf or .glb.
bool holds_several_surfaces(const std::filesystem::path& path);
/// Throws Error if write_mesh() does not support the extension.
void require_mesh_name(const std::filesystem::path& path);

/// Writes a mesh in the format of the extension, positions in LPS and mm (noted in a comment of the file):
/// .ply binary, polygonal cells, positions bit for bit, neighbours as vertex properties n1 n2 n3;
/// .obj polygonal cells; .stl binary, tessellated; .vtk (legacy, binary) and .vtp polydata with polygonal cells;
/// .3mf and .glb as write_surfaces(), with the name of the file.
/// Writes a temporary file and renames it. Throws Error for another extension, an empty or incomplete mesh, a missing
/// folder, or a failed write.
void write_mesh(const std::filesystem::path& path, const SimplexMesh& mesh);

/// Writes several surfaces, tessellated, to one file: .3mf (unit millimetre) or .glb (binary glTF 2.0, metres), see
/// mesh_formats.h. Throws Error for another extension, no surface, and as write_mesh().
void write_surfaces(const std::filesystem::path& path, std::span<const NamedSurface> surfaces);

/// Reads a mesh written by write_mesh(), except to .3mf and .glb, or another program, in mm and LPS. Converts positions
/// from RAS if a comment contains SPACE=RAS, except in .ply. A .ply with neighbours n1 n2 n3 is read bit for bit. For
/// other surfaces, see simplex_mesh_of(): polygons become cells if three meet at each vertex, else the mesh is the dual
/// of the triangulation. Throws Error if the file is missing, damaged or in an unsupported encoding
/// (surface_formats.h), a .ply names another frame than LPS or has polygons that disagree with the neighbours, the
/// surface is open, non-manifold or inconsistently oriented, or the mesh is invalid (validate()).
SimplexMesh read_mesh(const std::filesystem::path& path);

}  // namespace simplexseg
