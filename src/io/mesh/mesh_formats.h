// SPDX-License-Identifier: Apache-2.0
// Export of meshes to formats of other programs. surface_formats.h reads these formats; ply.h has the lossless format.
#pragma once
#include <string>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Comments in every mesh file; 3D Slicer reads the second one.
inline constexpr const char* mesh_frame = "frame LPS, unit mm";
inline constexpr const char* mesh_space = "SPACE=LPS";

/// Contents of a file in each format, as bytes.
std::string obj_of(const SimplexMesh& mesh);
std::string stl_of(const SimplexMesh& mesh);
std::string vtk_of(const SimplexMesh& mesh);
std::string vtp_of(const SimplexMesh& mesh);

}  // namespace simplexseg
