// SPDX-License-Identifier: Apache-2.0
// What a mesh starts from instead of the sphere of its seed, read from its file.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "image/mask.h"
#include "io/label_mesh.h"
#include "io/mesh_io.h"
#include "session/scene.h"

namespace simplexseg {

class JsonInput;

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

/// The JSON of a start without its mesh; `path`: what it is to be called there.
template <class Json>
Json start_json(const MeshStart& start, const std::string& path) {
  Json json = {{is_mesh_name(start.path) ? "mesh" : "labels", path}};
  if (start.value) json["label"] = *start.value;
  if (start.part > 0) json["part"] = start.part;
  return json;
}
/// Reads what start_json() makes; no file is read. Throws Error for an unknown key or a bad value.
MeshStart read_named_start(const JsonInput& input);

}  // namespace simplexseg
