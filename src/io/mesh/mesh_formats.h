// SPDX-License-Identifier: Apache-2.0
// Export of meshes to formats of other programs. surface_formats.h reads these formats; ply.h is the lossless format.
#pragma once
#include <string>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Comments that every mesh file contains; 3D Slicer reads the second one.
inline constexpr const char* mesh_frame = "frame LPS, unit mm";
inline constexpr const char* mesh_space = "SPACE=LPS";

/// Bytes of a file in each format. stl_of() tessellates the mesh, the others write its polygonal cells.
std::string obj_of(const SimplexMesh& mesh);
std::string stl_of(const SimplexMesh& mesh);
std::string vtk_of(const SimplexMesh& mesh);
std::string vtp_of(const SimplexMesh& mesh);

}  // namespace simplexseg
