// SPDX-License-Identifier: Apache-2.0
// Statistical model of a segmentation's organ in scenes and logs.
#pragma once
#include <filesystem>
#include <memory>
#include <string>

#include "session/scene.h"

namespace simplexseg {

class JsonInput;

/// Reads a model, for which find_data() searches. `checksum`: that it must have; "": any. Throws the errors of
/// find_data() and read_model(), and Error for another checksum.
std::shared_ptr<const MeshModel> load_mesh_model(const std::string& path, const std::filesystem::path& scene_folder,
                                                 const std::string& checksum = "");

/// JSON of a model. `path`: path to store instead of that of `model`.
template <class Json>
Json mesh_model_json(const MeshModel& model, const std::string& path) {
  return {{"file", path}, {"checksum", model.checksum}};
}
/// Model from the JSON of mesh_model_json(). Throws the errors of load_mesh_model(), and Error for an unknown key.
std::shared_ptr<const MeshModel> mesh_model_from_json(const JsonInput& input,
                                                      const std::filesystem::path& scene_folder);

}  // namespace simplexseg
