// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Said in every mesh file; the second half is what 3D Slicer looks for.
inline constexpr const char* mesh_frame = "frame LPS, unit mm";
inline constexpr const char* mesh_space = "SPACE=LPS";

/// The whole files as bytes.
std::string ply_of(const SimplexMesh& mesh);
std::string obj_of(const SimplexMesh& mesh);
std::string stl_of(const SimplexMesh& mesh);
std::string vtk_of(const SimplexMesh& mesh);
std::string vtp_of(const SimplexMesh& mesh);

/// Mesh of a PLY file's bytes, not yet validated; `name` is for messages.
SimplexMesh mesh_of_ply(const std::string& bytes, const std::string& name);

/// Appends the bytes of `value` as the machine has them.
template <class T>
void append(std::string& to, T value) {
  to.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace simplexseg
