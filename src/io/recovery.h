// SPDX-License-Identifier: Apache-2.0
// Work that is kept in case the program does not end as it should.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "io/held_folder.h"
#include "session/scene.h"
#include "session/undo_history.h"

namespace simplexseg {

/// What a user is told of work before it is taken up again.
struct WorkNote {
  std::string opened;           ///< path of the scene or volume that was open
  std::string scene_file;       ///< where the user saved the scene last; "": nowhere
  std::int64_t saved_at_s = 0;  ///< when it was kept, seconds since 1970
  int meshes = 0, points = 0;   ///< of the scene
  std::int64_t vertices = 0;    ///< of all meshes
};

/// Keeps the work of one window in a folder of its own below `root`. What was kept before stays until the next is whole
/// and on the disk: whenever the process is killed there is all of one of them. Not thread-safe: one thread at a time.
class WorkKeeper {
 public:
  /// Makes and holds a folder below `root`, and that where it is missing. Throws Error when it cannot.
  explicit WorkKeeper(const std::filesystem::path& root);
  /// Work that was kept goes with it: the program ended as it should.
  ~WorkKeeper();
  WorkKeeper(const WorkKeeper&) = delete;
  WorkKeeper& operator=(const WorkKeeper&) = delete;

  /// Of the history the steps that are nearest, in 16 MiB. Throws Error as write_scene does; what was kept before
  /// stays.
  void keep(const Scene& scene, WorkNote note, const UndoHistory& history = UndoHistory());
  /// There is nothing to be kept any more: it was saved, or is not wanted.
  void forget();
  bool has_work() const { return generation_ > 0; }
  const std::filesystem::path& folder() const { return folder_.path(); }

 private:
  HeldFolder folder_;
  int generation_ = 0, last_ = 0;
};

/// Work whose program is gone, held so that no other window takes it too.
struct LostWork {
  HeldFolder folder;
  WorkNote note;
  std::filesystem::path scene;  ///< to be read with load_scene()
};

/// All lost work below `root`, the latest first. Folders of programs that ended without work are removed. A folder
/// whose note cannot be read is left alone, and counts for nothing.
std::vector<LostWork> find_lost_work(const std::filesystem::path& root);

}  // namespace simplexseg
