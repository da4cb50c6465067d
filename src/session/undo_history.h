// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "session/command.h"
#include "session/scene.h"
#include "session/scene_snapshot.h"

namespace simplexseg {

/// Undo and redo by snapshots of whole scenes including poses (docs/adr/0007-undo-by-snapshot.md). Stores at most 200
/// snapshots and about 1 GiB for undo; arrays that do not change between snapshots are stored once. Copies share the
/// snapshots.
class UndoHistory {
 public:
  /// Command with the scene before it.
  struct Snapshot {
    Scene scene;
    Command command;
  };

  /// Action with the scene before it or, if it was undone, the scene after it.
  struct Entry {
    SceneSnapshot scene;
    Command command;
    std::string name;  ///< text of describe() for the command
  };
  using Entries = std::vector<std::shared_ptr<const Entry>>;
  static constexpr std::size_t kMaxSteps = 200;

  explicit UndoHistory(std::size_t max_bytes = std::size_t{1} << 30) : max_bytes_(max_bytes) {}
  /// Restores a history from to_undo() and to_redo() of another one.
  UndoHistory(Entries to_undo, Entries to_redo) : UndoHistory() {
    undo_ = std::move(to_undo), redo_ = std::move(to_redo);
  }

  bool can_undo() const { return !undo_.empty(); }
  bool can_redo() const { return !redo_.empty(); }
  const char* undo_title() const;  ///< title_of() the next action to undo; "": none
  const char* redo_title() const;
  /// Texts (describe()) of the actions that can be undone, oldest first.
  std::vector<std::string> undo_names() const;
  /// Texts of the actions that can be redone, beginning with the one that is redone next.
  std::vector<std::string> redo_names() const;
  const Entries& to_undo() const { return undo_; }  ///< the last entry is undone next
  const Entries& to_redo() const { return redo_; }  ///< the last entry is redone next
  /// Smallest id above those of all items in the history.
  ItemId next_id() const;
  /// Size of all snapshots for undo and redo, bytes.
  std::size_t bytes() const;

  /// Whether the command belongs to the same drag, slider movement or scroll gesture as the last one. Both are then
  /// undone together, without a further snapshot.
  bool continues(const Command& command) const;
  /// Adds the snapshot taken before a command, and discards the oldest snapshots beyond the limits.
  void push(Snapshot before);
  /// Clears redo, as every new command does.
  void clear_redo() { redo_.clear(); }

  /// Replaces the scene with the one before the last command. Returns false, with nothing changed, if there is none.
  bool undo(Scene& scene) { return exchange(scene, undo_, redo_); }
  /// Replaces the scene with the one after the command that was undone last. Returns false, with nothing changed, if
  /// there is none.
  bool redo(Scene& scene) { return exchange(scene, redo_, undo_); }

 private:
  static bool exchange(Scene& scene, Entries& from, Entries& to);

  std::size_t max_bytes_;
  Entries undo_, redo_;
};

}  // namespace simplexseg
