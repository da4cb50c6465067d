// SPDX-License-Identifier: Apache-2.0
#include "io/scene/scene_io.h"

#include <algorithm>
#include <limits>
#include <list>
#include <map>

#include "core/error.h"
#include "io/labels/label_file.h"
#include "io/mesh/mesh_io.h"
#include "io/mesh/ply.h"
#include "io/platform/atomic_file.h"
#include "io/platform/data_path.h"
#include "io/platform/files.h"
#include "io/scene/history_io.h"
#include "io/scene/json_input.h"
#include "io/scene/mesh_start.h"
#include "io/scene/pose_state.h"
#include "io/scene/scene_text.h"

namespace simplexseg {
namespace fs = std::filesystem;

namespace {

/// Path of a file; a relative path is relative to the folder of the scene.
fs::path file_beside(const JsonInput& input, const fs::path& folder) {
  const fs::path path = input.text();
  return path.is_absolute() ? path : folder / path;
}

void read_pose(const JsonInput& input, const fs::path& folder, MeshItem& item) {
  if (input.has("state") && !input.has("pose")) input["state"].fail("the key 'pose' is missing", "add it");
  if (!input.has("pose")) return;
  item.mesh = read_mesh(file_beside(input["pose"], folder));
  item.previous = item.mesh.positions;
  if (!input.has("state")) return;
  const fs::path state = file_beside(input["state"], folder);
  restore_pose_state(quoted(state), read_bytes(state), item);
  if (item.previous.empty()) item.previous = item.mesh.positions;
}

/// Label files of the meshes, by path, and the warnings of the labels read from them.
struct LabelFiles {
  std::map<fs::path, LabelFile> files;
  std::vector<std::string> warnings;
};

/// Reads a label, given by its number or its name in the file.
void read_label(const JsonInput& input, LabelChoice& choice) {
  if (input.is_text())
    choice.name = input.text();
  else
    choice.label = input.number();
}

void read_start(const JsonInput& input, const fs::path& folder, LabelFiles& files, int vertices, MeshItem& item) {
  input.expect_keys(start_keys());
  LoadedStart loaded;
  if (input.has("network")) {
    loaded = load_start(mesh_start_from_json(input), folder, vertices);
  } else if (input.has("mesh")) {
    for (const char* key : {"labels", "label", "part"})
      if (input.has(key)) input[key].fail("a start has either labels or a mesh", "delete one of them");
    const std::string path = absolute_if_found(input["mesh"].text(), folder);
    loaded = start_of_mesh(find_data(path, folder), path);
  } else {
    const std::string path = absolute_if_found(input["labels"].text(), folder);
    LabelChoice choice;
    if (input.has("label")) read_label(input["label"], choice);
    if (input.has("part")) choice.part = input["part"].integer_between(1, std::numeric_limits<int>::max());
    const fs::path file = find_data(path, folder);
    auto found = files.files.find(file);
    if (found == files.files.end()) found = files.files.emplace(file, LabelFile(file)).first;
    choice.label = label_of(choice, found->second.segments(), file);
    const LoadedLabels& labels = found->second.labels(choice);
    for (const std::string& warning : labels.warnings) {
      if (std::find(files.warnings.begin(), files.warnings.end(), warning) == files.warnings.end())
        files.warnings.push_back(warning);
    }
    loaded = start_of_labels(labels.volume, choice, path, vertices);
  }
  read_carried(input, loaded.start);
  item.seed = loaded.seed;
  item.start = std::move(loaded.start);
}

/// Ids of the meshes for file names: ids of the scene if they are distinct and above 0, else the meshes' indices from
/// 1.
std::vector<ItemId> file_ids(const Scene& scene) {
  std::vector<ItemId> ids;
  for (const MeshItem& item : scene.meshes) ids.push_back(item.id);
  std::vector<ItemId> sorted = ids;
  std::sort(sorted.begin(), sorted.end());
  const bool usable =
      std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end() && (sorted.empty() || sorted[0] > 0);
  for (std::size_t m = 0; m < ids.size() && !usable; ++m) ids[m] = static_cast<ItemId>(m + 1);
  return ids;
}

}  // namespace

SceneFile read_scene(const fs::path& path, SceneVolume volume) {
  const JsonInput input = JsonInput::open(path, "scene");
  const fs::path folder = path.parent_path();
  SceneFile file;
  LabelFiles label_files;
  file.scene = scene_of(input, folder, [&](const JsonInput& mesh, MeshItem& item) {
    if (mesh.has("start")) read_start(mesh["start"], folder, label_files, item.final_vertices, item);
    read_pose(mesh, folder, item);
  });
  if (volume == SceneVolume::Find && input.has("volume")) file.volume = find_data(input["volume"].text(), folder);
  file.warnings.insert(file.warnings.end(), label_files.warnings.begin(), label_files.warnings.end());
  return file;
}

void write_scene(const fs::path& path, const Scene& scene, const UndoHistory& history, std::size_t max_bytes) {
  for (const MeshItem& item : scene.meshes) {
    if (item.mesh.positions.empty()) continue;
    try {
      validate(item.mesh);  // an invalid mesh could not be read again
    } catch (const Error& error) {
      throw Error("cannot write " + quoted(path),
                  "the surface of '" + one_line(item.name) + "' is invalid (" + error.what() + ")", "reset its pose");
    }
  }
  const fs::path folder = path.parent_path();
  std::list<AtomicFile> files;  // renamed when all are complete, the scene itself last
  AtomicFile scene_file(path);
  std::vector<std::string> poses;
  const std::vector<ItemId> ids = file_ids(scene);
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const MeshItem& item = scene.meshes[m];
    std::string& name = poses.emplace_back();
    if (item.mesh.positions.empty()) continue;
    name = path.stem().string() + ".mesh-" + std::to_string(ids[m]);
    write_bytes(files.emplace_back(folder / (name + ".ply")), ply_of(item.mesh));
    write_bytes(files.emplace_back(folder / (name + ".state")), pose_state_bytes(item));
  }
  const bool has_history = history.can_undo() || history.can_redo();
  if (has_history) write_history(files.emplace_back(history_path(path)), path, scene, history, max_bytes);
  write_bytes(scene_file, scene_text(path, scene, poses));
  for (AtomicFile& file : files) file.commit();
  scene_file.commit();
  if (!has_history) remove_history(path);
}

}  // namespace simplexseg
