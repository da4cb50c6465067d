// SPDX-License-Identifier: Apache-2.0
// Surfaces as other programs write them; mesh_formats.h has what is written.
#pragma once
#include <string>

#include "io/polygon_surface.h"

namespace simplexseg {

/// The polygons in a whole file's bytes; positions are LPS unless its comments say SPACE=RAS, and are turned to LPS
/// then. STL binary or ASCII; OBJ; VTK legacy polydata, binary or ASCII, up to version 5; VTP with raw appended or
/// ASCII data. Refuses what is damaged or kept in another way.
PolygonSurface surface_of_stl(const std::string& bytes, const Refuse& refuse);
PolygonSurface surface_of_obj(const std::string& bytes, const Refuse& refuse);
PolygonSurface surface_of_vtk(const std::string& bytes, const Refuse& refuse);
PolygonSurface surface_of_vtp(const std::string& bytes, const Refuse& refuse);

}  // namespace simplexseg
