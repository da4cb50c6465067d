// SPDX-License-Identifier: Apache-2.0
// Export of meshes to formats of other programs. surface_formats.h reads these formats; ply.h is the lossless format.
#pragma once
#include <span>
#include <string>

#include "io/mesh/named_surface.h"

namespace simplexseg {

/// Comments that every mesh file contains; 3D Slicer reads the second one.
inline constexpr const char* mesh_frame = "frame LPS, unit mm";
inline constexpr const char* mesh_space = "SPACE=LPS";

/// Bytes of a file in each format. stl_of() tessellates the mesh, the others write its polygonal cells.
std::string obj_of(const SimplexMesh& mesh);
std::string stl_of(const SimplexMesh& mesh);
std::string vtk_of(const SimplexMesh& mesh);
std::string vtp_of(const SimplexMesh& mesh);

/// Bytes of a file of several tessellated surfaces, at least one, none of which is empty, with names and colours.
/// Binary glTF 2.0: one node each; units are metres, +Y is superior and +Z anterior by the transform of their common
/// parent, while the coordinates of the meshes are LPS in mm. 3MF: one object each, LPS, with the unit millimetre.
/// Throws Error for more than 4 GiB of glTF, and as require_three_mf().
std::string glb_of(std::span<const NamedSurface> surfaces);
std::string three_mf_of(std::span<const NamedSurface> surfaces);
/// Throws Error if this program was built without the library that writes 3MF.
void require_three_mf();

}  // namespace simplexseg
