// SPDX-License-Identifier: Apache-2.0
// What a mesh starts from instead of the sphere of its seed, read from its file.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "image/mask.h"
#include "io/label_mesh.h"
#include "session/scene.h"

namespace simplexseg {

/// A start with its mesh, and a ball within it for the seed.
struct LoadedStart {
  MeshStart start;
  Seed seed;
  std::vector<std::string> warnings;  ///< of load_labels(), of a file that was read for it
};

/// Of a label volume that was read already. `path`: what the scene is to call it; `vertices`: as mesh_of_mask() takes
/// them. Throws Error as choose_label() does.
LoadedStart start_of_labels(const Volume& labels, const LabelChoice& choice, const std::string& path, int vertices = 0);
/// Of a mesh file. Throws Error as read_mesh() does, and for a mesh that holds nothing.
LoadedStart start_of_mesh(const std::filesystem::path& file, const std::string& path);

/// Reads the file again that `wanted` names (its mesh may be null), looked for as find_data() does.
LoadedStart load_start(const MeshStart& wanted, const std::filesystem::path& beside, int vertices = 0);

}  // namespace simplexseg
