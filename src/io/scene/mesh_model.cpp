// SPDX-License-Identifier: Apache-2.0
#include "io/scene/mesh_model.h"

#include <limits>

#include "core/error.h"
#include "io/platform/data_path.h"
#include "io/platform/files.h"
#include "io/scene/json_input.h"
#include "io/scene/scene_text.h"

namespace simplexseg {
namespace {

constexpr int kLargestMeshId = std::numeric_limits<int>::max();

}  // namespace

std::shared_ptr<const MeshModel> load_mesh_model(const std::string& path, const std::filesystem::path& scene_folder,
                                                 const std::string& checksum, int number) {
  const std::filesystem::path file = find_data(path, scene_folder);
  const ModelFile model = read_model(file);
  if (!checksum.empty() && model.checksum != checksum)
    throw Error("model " + quoted(file), "it is not the one with which this was saved: its checksum differs",
                "restore the earlier file, or remove the model from the segmentation");
  if (number < 0 || number >= std::ssize(model.organs))
    throw Error("model " + quoted(file), "it has no organ number " + std::to_string(number + 1),
                "restore the earlier file, or remove the model from the segmentation");
  return mesh_model_of(model, path, number);
}

std::shared_ptr<const MeshModel> mesh_model_of(const ModelFile& model, const std::string& path, int number) {
  auto loaded = std::make_shared<MeshModel>();
  loaded->path = path;
  loaded->checksum = model.checksum;
  loaded->organ = std::make_shared<const OrganModel>(model.organs[number]);
  loaded->number = number;
  return loaded;
}

std::shared_ptr<const MeshModel> mesh_model_from_json(const JsonInput& input,
                                                      const std::filesystem::path& scene_folder) {
  input.expect_keys({"file", "checksum", "organ"});
  return load_mesh_model(absolute_if_found(input["file"].text(), scene_folder), scene_folder,
                         input.has("checksum") ? input["checksum"].text() : "",
                         input.has("organ") ? input["organ"].integer_between(1, 10000) - 1 : 0);
}

std::vector<float> read_modes(const JsonInput& input) {
  std::vector<float> modes;
  modes.reserve(static_cast<std::size_t>(input.size()));
  for (int m = 0; m < input.size(); ++m) modes.push_back(static_cast<float>(input[m].number()));
  return modes;
}

void read_model_keys(const JsonInput& input, SetModel& command) {
  input.expect_keys({"command", "after_steps", "mesh", "model"});
  command.mesh = static_cast<ItemId>(input["mesh"].integer_between(0, kLargestMeshId));
  if (input.has("model")) command.model = mesh_model_from_json(input["model"], {});
}

void read_model_keys(const JsonInput& input, SetStartModes& command) {
  input.expect_keys({"command", "after_steps", "mesh", "modes", "continues"});
  command.mesh = static_cast<ItemId>(input["mesh"].integer_between(0, kLargestMeshId));
  command.modes = read_modes(input["modes"]);
  command.continues = input.has("continues") && input["continues"].boolean();
}

void read_model_keys(const JsonInput& input, RecordProfiles& command) {
  input.expect_keys({"command", "after_steps", "mesh", "from_model"});
  command.mesh = static_cast<ItemId>(input["mesh"].integer_between(0, kLargestMeshId));
  command.from_model = input.has("from_model") && input["from_model"].boolean();
}

}  // namespace simplexseg
