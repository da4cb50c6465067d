// SPDX-License-Identifier: Apache-2.0
// Statistical model of a segmentation's organ in scenes and logs.
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "io/model/model_file.h"
#include "session/command.h"
#include "session/scene.h"

namespace simplexseg {

class JsonInput;

/// Reads a model, for which find_data() searches. `checksum`: that it must have; "": any; `number`: index of the organ
/// in the file. Throws the errors of find_data() and read_model(), and Error for another checksum or an organ that the
/// file does not have.
std::shared_ptr<const MeshModel> load_mesh_model(const std::string& path, const std::filesystem::path& scene_folder,
                                                 const std::string& checksum = "", int number = 0);
/// Organ of a model that has been read. `path`: MeshModel::path.
std::shared_ptr<const MeshModel> mesh_model_of(const ModelFile& model, const std::string& path, int number);

/// JSON of a model. `path`: path to store instead of that of `model`.
template <class Json>
Json mesh_model_json(const MeshModel& model, const std::string& path) {
  Json json{{"file", path}, {"checksum", model.checksum}};
  if (model.number > 0) json["organ"] = model.number + 1;
  return json;
}
/// Model from the JSON of mesh_model_json(). Throws the errors of load_mesh_model(), and Error for an unknown key.
std::shared_ptr<const MeshModel> mesh_model_from_json(const JsonInput& input,
                                                      const std::filesystem::path& scene_folder);

/// Coefficients of modes (MeshItem::start_modes).
std::vector<float> read_modes(const JsonInput& input);

/// Keys of the commands of models in logs.
template <class Json>
Json model_keys_json(const SetModel& command) {
  Json json{{"mesh", command.mesh}};
  if (command.model) json["model"] = mesh_model_json<Json>(*command.model, command.model->path);
  return json;
}
template <class Json>
Json model_keys_json(const SetStartModes& command) {
  Json json{{"mesh", command.mesh}, {"modes", command.modes}};
  if (command.continues) json["continues"] = true;
  return json;
}
template <class Json>
Json model_keys_json(const RecordProfiles& command) {
  Json json{{"mesh", command.mesh}};
  if (command.from_model) json["from_model"] = true;
  return json;
}
/// Reads these keys; others than those of every command ("command", "after_steps") are refused.
void read_model_keys(const JsonInput& input, SetModel& command);
void read_model_keys(const JsonInput& input, SetStartModes& command);
void read_model_keys(const JsonInput& input, RecordProfiles& command);

}  // namespace simplexseg
