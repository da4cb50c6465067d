// SPDX-License-Identifier: Apache-2.0
// Formats that other programs read a mesh from; surface_formats.h reads them, ply.h has the one that keeps every bit.
#pragma once
#include <string>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Said in every mesh file; the second half is what 3D Slicer looks for.
inline constexpr const char* mesh_frame = "frame LPS, unit mm";
inline constexpr const char* mesh_space = "SPACE=LPS";

/// The whole files as bytes.
std::string obj_of(const SimplexMesh& mesh);
std::string stl_of(const SimplexMesh& mesh);
std::string vtk_of(const SimplexMesh& mesh);
std::string vtp_of(const SimplexMesh& mesh);

}  // namespace simplexseg
