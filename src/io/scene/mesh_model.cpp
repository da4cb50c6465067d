// SPDX-License-Identifier: Apache-2.0
#include "io/scene/mesh_model.h"

#include "core/error.h"
#include "io/model/model_file.h"
#include "io/platform/data_path.h"
#include "io/platform/files.h"
#include "io/scene/json_input.h"
#include "io/scene/scene_text.h"

namespace simplexseg {

std::shared_ptr<const MeshModel> load_mesh_model(const std::string& path, const std::filesystem::path& scene_folder,
                                                 const std::string& checksum) {
  const std::filesystem::path file = find_data(path, scene_folder);
  ModelFile model = read_model(file);
  if (!checksum.empty() && model.checksum != checksum)
    throw Error("model " + quoted(file), "it is not the one with which this was saved: its checksum differs",
                "restore the earlier file, or remove the model from the segmentation");
  auto loaded = std::make_shared<MeshModel>();
  loaded->path = path;
  loaded->checksum = std::move(model.checksum);
  loaded->organ = std::make_shared<const OrganModel>(std::move(model.organs.front()));
  return loaded;
}

std::shared_ptr<const MeshModel> mesh_model_from_json(const JsonInput& input,
                                                      const std::filesystem::path& scene_folder) {
  input.expect_keys({"file", "checksum"});
  return load_mesh_model(absolute_if_found(input["file"].text(), scene_folder), scene_folder,
                         input.has("checksum") ? input["checksum"].text() : "");
}

}  // namespace simplexseg
