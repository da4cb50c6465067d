// SPDX-License-Identifier: Apache-2.0
#include "io/scene/recovery.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.h"
#include "io/platform/atomic_file.h"
#include "io/platform/files.h"
#include "io/scene/json_input.h"
#include "io/scene/json_output.h"
#include "io/scene/scene_io.h"

namespace simplexseg {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr const char *kInfo = "work.json", *kScene = "scene.json";
constexpr const char* kWindowPrefix = "window-";
/// Largest size of the saved history, bytes. Each autosave writes the whole history again.
constexpr std::size_t kMaxHistory = std::size_t{16} << 20;

/// Creates a folder with a unique name below `root`.
fs::path make_folder(const fs::path& root) {
  std::error_code failure;
  fs::create_directories(root, failure);
  fs::permissions(root, fs::perms::owner_all, failure);  // file names may contain patient names
  std::string name = (root / (std::string(kWindowPrefix) + "XXXXXX")).string();
  if (!::mkdtemp(name.data())) {
    const int reason = errno;
    throw write_error("cannot save recovery data in " + quoted(root), root, reason);
  }
  return name;
}

std::string generation_name(int generation) { return "kept-" + std::to_string(generation); }

/// Reads and checks the description of an autosave.
RecoverableWork read_info(const fs::path& folder) {
  const JsonInput input = JsonInput::open(folder / kInfo, "recovery");
  input.expect_keys({"simplexseg_work", "kept", "opened", "scene_file", "saved_at_s", "meshes", "points", "vertices"});
  input["simplexseg_work"].integer_between(1, 1);
  constexpr int kMaxInt = std::numeric_limits<int>::max();
  RecoverableWork work;
  work.info.opened = input["opened"].text_or_empty();
  work.info.scene_file = input["scene_file"].text_or_empty();
  work.info.saved_at_s = static_cast<std::int64_t>(input["saved_at_s"].number());
  work.info.meshes = input["meshes"].integer_between(0, kMaxInt);
  work.info.points = input["points"].integer_between(0, kMaxInt);
  work.info.vertices = static_cast<std::int64_t>(input["vertices"].number());
  work.scene = folder / generation_name(input["kept"].integer_between(1, kMaxInt)) / kScene;
  require_file(work.scene);
  return work;
}

}  // namespace

AutosaveStore::AutosaveStore(const fs::path& root) {
  // Another window that is starting may take a folder that is not locked yet for an abandoned one, and lock it first.
  for (int attempt = 0; attempt < 10 && !folder_.is_locked(); ++attempt) folder_ = LockedFolder(make_folder(root));
  if (!folder_.is_locked())
    throw Error("cannot save recovery data in " + quoted(root), "files in it cannot be locked", "use a local disk");
}

AutosaveStore::~AutosaveStore() { folder_.remove(); }

void AutosaveStore::save(const Scene& scene, AutosaveInfo info, const UndoHistory& history) {
  const int next = last_ + 1;
  const fs::path folder = folder_.path() / generation_name(next);
  std::error_code ignored;
  try {
    fs::create_directory(folder, ignored);
    write_scene(folder / kScene, scene, history, kMaxHistory);
    info.meshes = static_cast<int>(scene.meshes.size());
    info.points = static_cast<int>(scene.points.size());
    info.vertices = 0;
    for (const MeshItem& item : scene.meshes) info.vertices += item.mesh.vertex_count();
    const Json json = {{"simplexseg_work", 1},          {"kept", next},
                       {"opened", info.opened},         {"scene_file", info.scene_file},
                       {"saved_at_s", info.saved_at_s}, {"meshes", info.meshes},
                       {"points", info.points},         {"vertices", info.vertices}};
    AtomicFile file(folder_.path() / kInfo);
    write_bytes(file, json_text(folder_.path() / kInfo, json));
    file.commit();
  } catch (...) {
    fs::remove_all(folder, ignored);
    throw;
  }
  last_ = next;
  if (const int before = std::exchange(generation_, next); before > 0)
    fs::remove_all(folder_.path() / generation_name(before), ignored);
}

void AutosaveStore::discard() {
  if (generation_ == 0) return;
  std::error_code ignored;
  fs::remove(folder_.path() / kInfo, ignored);  // first: without this file nothing is offered for recovery
  fs::remove_all(folder_.path() / generation_name(std::exchange(generation_, 0)), ignored);
}

std::vector<RecoverableWork> find_recoverable_work(const fs::path& root) {
  std::vector<RecoverableWork> all;
  std::vector<fs::path> folders;
  std::error_code failure;
  for (fs::directory_iterator it(root, failure), end; !failure && it != end; it.increment(failure)) {
    std::error_code ignored;
    if (it->path().filename().string().starts_with(kWindowPrefix) && it->is_directory(ignored))
      folders.push_back(it->path());
  }
  for (const fs::path& path : folders) {
    LockedFolder folder(path);
    if (!folder.is_locked()) continue;
    std::error_code ignored;
    if (!fs::exists(path / kInfo, ignored)) {
      folder.remove();
      continue;
    }
    try {
      RecoverableWork work = read_info(path);
      work.folder = std::move(folder);
      all.push_back(std::move(work));
    } catch (const Error&) {
      continue;
    }
  }
  std::sort(all.begin(), all.end(),
            [](const RecoverableWork& a, const RecoverableWork& b) { return a.info.saved_at_s > b.info.saved_at_s; });
  return all;
}

}  // namespace simplexseg
