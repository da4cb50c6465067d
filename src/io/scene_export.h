// SPDX-License-Identifier: Apache-2.0
// What comes out of a scene, for other programs: one exporter for the window and the command line.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "session/scene.h"

namespace simplexseg {

/// Rasterises all meshes of a scene onto the grid, each with its label, and writes the labels. Returns a line for the
/// user where voxels lie inside several meshes, else nothing. Throws Error as make_label_map() and write_labels() do.
std::string save_labels(const std::filesystem::path& path, const Scene& scene, const VolumeGeometry& geometry);

/// The names of the files that save_meshes() writes, in the order of the scene's meshes: those of the meshes where they
/// can be file names (distinct_file_names()), with .ply.
std::vector<std::string> mesh_file_names(const Scene& scene);

/// Writes each mesh of a scene as a file of its own into the folder, which must exist; files of these names are
/// replaced. Returns the files. Throws Error as write_mesh() does.
std::vector<std::filesystem::path> save_meshes(const std::filesystem::path& folder, const Scene& scene);

}  // namespace simplexseg
