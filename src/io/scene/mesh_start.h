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
#include "io/scene/json_output.h"
#include "session/command.h"

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
/// Makes a start from the mask of a network, with the same surface as start_of_labels(). `error_mm`, `vertices`: see
/// MeshStart, mesh_of_mask(). Throws Error for an empty mask.
LoadedStart start_of_network(std::shared_ptr<const NetworkMask> mask, double error_mm, int vertices = 0);
/// Makes a start from the mesh in `file`. `path`: path to store in the scene. Throws the errors of read_mesh(), and
/// Error for a mesh that encloses no volume.
LoadedStart start_of_mesh(const std::filesystem::path& file, const std::string& path);

/// Reads the surface of a start from its file, for which find_data() searches, or makes it from the mask of a network;
/// ignores MeshStart::mesh. `vertices`:
/// parameter of mesh_of_mask() for a label volume. Throws the errors of find_data(), load_labels(), start_of_labels()
/// and start_of_mesh().
LoadedStart load_start(const MeshStart& start, const std::filesystem::path& scene_folder, int vertices = 0);

/// JSON of the mask of a network.
template <class Json>
Json network_json(const NetworkMask& mask) {
  Json json = {{"server", mask.server}};
  if (!mask.network.empty()) json["name"] = mask.network;
  if (!mask.licence.empty()) json["licence"] = mask.licence;
  json["voxels"] = voxels_json<Json>(mask.voxels);
  return json;
}

/// JSON of a start without its mesh. `path`: path to store in the JSON instead of that of `start`.
template <class Json>
Json start_json(const MeshStart& start, const std::string& path) {
  Json json = Json::object();
  if (start.network)
    json["network"] = network_json<Json>(*start.network);
  else
    json[is_mesh_name(start.path) ? "mesh" : "labels"] = path;
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
/// JSON of the keys of SetStart.
template <class Json>
Json set_start_json(const SetStart& command) {
  Json json = {{"mesh", command.mesh}};
  if (command.start) json["start"] = start_json<Json>(*command.start, command.start->path);
  return json;
}
void read_set_start(const JsonInput& input, SetStart& command);
/// Reads the surface of the start of a command, if it has one. Throws the errors of load_start().
void load_start_of(Command& command);
/// Keys of start_json().
inline std::vector<std::string> start_keys() {
  return {"labels", "label", "part", "mesh", "error_mm", "earlier", "network"};
}
/// Sets the attributes of a start of a carried surface from the JSON of start_json(). Throws Error for an invalid
/// value.
void read_carried(const JsonInput& input, MeshStart& start);
/// Reads the mask of a network from the JSON of network_json().
std::shared_ptr<const NetworkMask> read_network(const JsonInput& input);
/// Start from the JSON of start_json(), without its mesh. Throws Error for an unknown key or an invalid value.
MeshStart mesh_start_from_json(const JsonInput& input);

}  // namespace simplexseg
