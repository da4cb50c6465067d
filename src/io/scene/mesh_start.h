// SPDX-License-Identifier: Apache-2.0
// Start surface of a mesh, read from a label volume or a mesh file. It replaces the sphere of the seed.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "image/mask.h"
#include "io/labels/label_mesh.h"
#include "io/mesh/mesh_io.h"
#include "session/scene.h"

namespace simplexseg {

class JsonInput;

/// Start surface, and a ball inside it for the seed.
struct LoadedStart {
  MeshStart start;
  Seed seed;
  std::vector<std::string> warnings;  ///< warnings of load_labels()
};

/// Makes a start from a label volume in memory; fills small cavities of the label. `path`: path to store in the scene;
/// `vertices`: parameter of mesh_of_mask(). Throws the errors of choose_label().
LoadedStart start_of_labels(const Volume& labels, const LabelChoice& choice, const std::string& path, int vertices = 0);
/// Makes a start from the mesh in `file`. `path`: path to store in the scene. Throws the errors of read_mesh(), and
/// Error for a mesh that encloses no volume.
LoadedStart start_of_mesh(const std::filesystem::path& file, const std::string& path);

/// Reads the surface of a start from its file, for which find_data() searches; ignores MeshStart::mesh. `vertices`:
/// parameter of mesh_of_mask() for a label volume. Throws the errors of find_data(), load_labels(), start_of_labels()
/// and start_of_mesh().
LoadedStart load_start(const MeshStart& start, const std::filesystem::path& scene_folder, int vertices = 0);

/// JSON of a start without its mesh. `path`: path to store in the JSON instead of that of `start`.
template <class Json>
Json start_json(const MeshStart& start, const std::string& path) {
  Json json = {{is_mesh_name(start.path) ? "mesh" : "labels", path}};
  if (start.value) json["label"] = *start.value;
  if (start.part > 0) json["part"] = start.part;
  if (start.error_mm > 0) json["error_mm"] = start.error_mm;
  if (start.earlier.volume_ml > 0) {
    const EarlierObject& earlier = start.earlier;
    const Eigen::Vector3d& c = earlier.centroid_mm;
    json["earlier"] = {{"volume_ml", earlier.volume_ml},
                       {"long_mm", earlier.long_mm},
                       {"short_mm", earlier.short_mm},
                       {"centroid_mm", {c.x(), c.y(), c.z()}}};
  }
  return json;
}
/// Keys of start_json().
inline std::vector<std::string> start_keys() { return {"labels", "label", "part", "mesh", "error_mm", "earlier"}; }
/// Sets the attributes of a start of a carried surface from the JSON of start_json(). Throws Error for an invalid
/// value.
void read_carried(const JsonInput& input, MeshStart& start);
/// Start from the JSON of start_json(), without its mesh. Throws Error for an unknown key or an invalid value.
MeshStart mesh_start_from_json(const JsonInput& input);

}  // namespace simplexseg
