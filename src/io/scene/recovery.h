// SPDX-License-Identifier: Apache-2.0
// Autosave and recovery of unsaved work.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "io/platform/locked_folder.h"
#include "session/scene.h"
#include "session/undo_history.h"

namespace simplexseg {

/// Description of an autosave, shown to the user before it is restored.
struct AutosaveInfo {
  std::string opened;           ///< path of the scene or volume that was open
  std::string scene_file;       ///< scene file last saved by the user; empty if never saved
  std::int64_t saved_at_s = 0;  ///< time of the autosave, seconds since 1970-01-01 UTC
  int meshes = 0, points = 0;   ///< numbers of meshes and points in the scene
  std::int64_t vertices = 0;    ///< number of vertices of all meshes
};

/// Autosave of one window, in a separate folder below `root`. The previous autosave stays until the next one is
/// complete and on the disk, so that after the first save() a complete autosave exists whenever the process is killed.
/// Not thread-safe.
class AutosaveStore {
 public:
  /// Creates and locks a folder below `root`; creates `root` if it is missing. Throws Error if this fails.
  explicit AutosaveStore(const std::filesystem::path& root);
  /// Deletes the autosave and its folder, because the program ends normally.
  ~AutosaveStore();
  AutosaveStore(const AutosaveStore&) = delete;
  AutosaveStore& operator=(const AutosaveStore&) = delete;

  /// Saves the scene and the steps of the history nearest to the present, up to 16 MiB. Sets the numbers in `info`.
  /// Throws the errors of write_scene(); the previous autosave then stays.
  void save(const Scene& scene, AutosaveInfo info, const UndoHistory& history = UndoHistory());
  /// Deletes the autosave, after the user has saved or discarded the work.
  void discard();
  bool has_autosave() const { return generation_ > 0; }
  const std::filesystem::path& folder() const { return folder_.path(); }

 private:
  LockedFolder folder_;
  int generation_ = 0, last_ = 0;
};

/// Autosave of a program that ended without deleting it, locked against other windows.
struct RecoverableWork {
  LockedFolder folder;
  AutosaveInfo info;
  std::filesystem::path scene;  ///< scene file for load_scene()
};

/// All autosaves below `root` whose program has ended, the latest first. Deletes unlocked folders without an autosave.
/// Ignores folders whose description cannot be read.
std::vector<RecoverableWork> find_recoverable_work(const std::filesystem::path& root);

}  // namespace simplexseg
