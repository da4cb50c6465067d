// SPDX-License-Identifier: Apache-2.0
#include "io/recovery.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/files.h"
#include "io/json_input.h"
#include "io/json_output.h"
#include "io/scene_io.h"

namespace simplexseg {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr const char *kNote = "work.json", *kScene = "scene.json";
constexpr const char* kPrefix = "window-";
/// All of it is written after each action.
constexpr std::size_t kMostHistory = std::size_t{16} << 20;

/// A folder of a name that no other process has.
fs::path make_folder(const fs::path& root) {
  std::error_code failure;
  fs::create_directories(root, failure);
  fs::permissions(root, fs::perms::owner_all, failure);  // images of patients have names
  std::string name = (root / (std::string(kPrefix) + "XXXXXX")).string();
  if (!::mkdtemp(name.data()))
    throw Error("cannot keep the work in " + quoted(root), one_line(std::strerror(errno)),
                "check the permissions and the space left on the disk");
  return name;
}

std::string generation_name(int generation) { return "kept-" + std::to_string(generation); }

LostWork read_note(const fs::path& folder) {
  const JsonInput input = JsonInput::open(folder / kNote, "note of kept work");
  input.expect_keys({"simplexseg_work", "kept", "opened", "scene_file", "saved_at_s", "meshes", "points", "vertices"});
  input["simplexseg_work"].integer_between(1, 1);
  constexpr int kMost = std::numeric_limits<int>::max();
  LostWork work;
  work.note.opened = input["opened"].text_or_empty();
  work.note.scene_file = input["scene_file"].text_or_empty();
  work.note.saved_at_s = static_cast<std::int64_t>(input["saved_at_s"].number());
  work.note.meshes = input["meshes"].integer_between(0, kMost);
  work.note.points = input["points"].integer_between(0, kMost);
  work.note.vertices = static_cast<std::int64_t>(input["vertices"].number());
  work.scene = folder / generation_name(input["kept"].integer_between(1, kMost)) / kScene;
  require_file(work.scene);
  return work;
}

}  // namespace

WorkKeeper::WorkKeeper(const fs::path& root) {
  // A window that starts at this moment may take a folder without a lock for one that was left.
  for (int attempt = 0; attempt < 10 && !folder_.holds(); ++attempt) folder_ = HeldFolder(make_folder(root));
  if (!folder_.holds())
    throw Error("cannot keep the work in " + quoted(root), "its file cannot be locked", "use a local disk");
}

WorkKeeper::~WorkKeeper() { folder_.remove(); }

void WorkKeeper::keep(const Scene& scene, WorkNote note, const UndoHistory& history) {
  const int next = last_ + 1;
  const fs::path folder = folder_.path() / generation_name(next);
  std::error_code ignored;
  try {
    fs::create_directory(folder, ignored);
    write_scene(folder / kScene, scene, history, kMostHistory);
    note.meshes = static_cast<int>(scene.meshes.size());
    note.points = static_cast<int>(scene.points.size());
    note.vertices = 0;
    for (const MeshItem& item : scene.meshes) note.vertices += item.mesh.vertex_count();
    const Json json = {{"simplexseg_work", 1},          {"kept", next},
                       {"opened", note.opened},         {"scene_file", note.scene_file},
                       {"saved_at_s", note.saved_at_s}, {"meshes", note.meshes},
                       {"points", note.points},         {"vertices", note.vertices}};
    AtomicFile file(folder_.path() / kNote);
    write_bytes(file, json_text(folder_.path() / kNote, json));
    file.commit();
  } catch (...) {
    fs::remove_all(folder, ignored);
    throw;
  }
  last_ = next;
  if (const int before = std::exchange(generation_, next); before > 0)
    fs::remove_all(folder_.path() / generation_name(before), ignored);
}

void WorkKeeper::forget() {
  if (generation_ == 0) return;
  std::error_code ignored;
  fs::remove(folder_.path() / kNote, ignored);  // first: without it there is nothing to be found
  fs::remove_all(folder_.path() / generation_name(std::exchange(generation_, 0)), ignored);
}

std::vector<LostWork> find_lost_work(const fs::path& root) {
  std::vector<LostWork> all;
  std::vector<fs::path> folders;
  std::error_code failure;
  for (fs::directory_iterator it(root, failure), end; !failure && it != end; it.increment(failure)) {
    std::error_code ignored;
    if (it->path().filename().string().starts_with(kPrefix) && it->is_directory(ignored)) folders.push_back(it->path());
  }
  for (const fs::path& path : folders) {
    HeldFolder folder(path);
    if (!folder.holds()) continue;
    std::error_code ignored;
    if (!fs::exists(path / kNote, ignored)) {
      folder.remove();
      continue;
    }
    try {
      LostWork work = read_note(path);
      work.folder = std::move(folder);
      all.push_back(std::move(work));
    } catch (const Error&) {
      continue;
    }
  }
  std::sort(all.begin(), all.end(),
            [](const LostWork& a, const LostWork& b) { return a.note.saved_at_s > b.note.saved_at_s; });
  return all;
}

}  // namespace simplexseg
