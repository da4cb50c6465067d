// SPDX-License-Identifier: Apache-2.0
// Import of surfaces written by other programs; mesh_formats.h exports them.
#pragma once
#include <string>

#include "io/mesh/polygon_surface.h"

namespace simplexseg {

/// Polygons from the bytes of a file. Positions are LPS, mm; they are converted from RAS if a comment contains
/// SPACE=RAS or, in VTK and VTP files, the field SPACE is RAS. Triangle strips and all pieces of a VTP file are read.
/// Supports STL, binary or ASCII; OBJ; legacy VTK polydata up to version 5, binary or ASCII; VTP,
/// little-endian, with uncompressed raw appended data or ASCII data. Calls `fail` for a damaged file or another
/// encoding.
PolygonSurface surface_of_stl(const std::string& bytes, const Fail& fail);
PolygonSurface surface_of_obj(const std::string& bytes, const Fail& fail);
PolygonSurface surface_of_vtk(const std::string& bytes, const Fail& fail);
PolygonSurface surface_of_vtp(const std::string& bytes, const Fail& fail);

}  // namespace simplexseg
