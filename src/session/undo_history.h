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

/// What can be taken back and done again: whole scenes, poses included, for undo is an exchange of scenes
/// (docs/adr/0007-undo-by-snapshot.md). At most 200 are kept for undo, and no more than about 1 GiB of them; what does
/// not change from one to the next is kept once. Copies share all that is kept.
class UndoHistory {
 public:
  /// The scene as it was before the command.
  struct Snapshot {
    Scene scene;
    Command command;
  };

  /// What is kept of an action: the scene before it, or, where it was taken back, the one after it.
  struct Entry {
    SceneSnapshot scene;
    Command command;
    std::string name;  ///< as describe() said it
  };
  using Entries = std::vector<std::shared_ptr<const Entry>>;
  static constexpr std::size_t kMostSteps = 200;

  explicit UndoHistory(std::size_t most_bytes = std::size_t{1} << 30) : most_bytes_(most_bytes) {}
  /// Of what to_undo() and to_redo() of another one gave.
  UndoHistory(Entries to_undo, Entries to_redo) : UndoHistory() {
    undo_ = std::move(to_undo), redo_ = std::move(to_redo);
  }

  bool can_undo() const { return !undo_.empty(); }
  bool can_redo() const { return !redo_.empty(); }
  const char* undo_title() const;  ///< "" when there is none
  const char* redo_title() const;
  /// What undo takes back, the oldest first, and what redo does again, the next first; as describe() says it.
  std::vector<std::string> undo_names() const;
  std::vector<std::string> redo_names() const;
  const Entries& to_undo() const { return undo_; }  ///< the next last
  const Entries& to_redo() const { return redo_; }  ///< the next last
  /// The next id that no mesh and no point in it has.
  ItemId next_id() const;
  /// Of what is kept, for undo and redo together.
  std::size_t bytes() const;

  /// Whether the command goes on with the drag or the slider movement that the last snapshot precedes: the two are
  /// taken back together, so no snapshot is due.
  bool continues(const Command& command) const;
  /// Keeps a snapshot of before a command that was carried out.
  void keep(Snapshot before);
  /// A new command was carried out: what was taken back before it cannot be done again.
  void forget_undone() { redo_.clear(); }

  /// Exchange the scene for that before the last command, or after the one taken back last. False, with nothing
  /// changed, when there is none.
  bool undo(Scene& scene) { return exchange(scene, undo_, redo_); }
  bool redo(Scene& scene) { return exchange(scene, redo_, undo_); }

 private:
  static bool exchange(Scene& scene, Entries& from, Entries& to);

  std::size_t most_bytes_;
  Entries undo_, redo_;
};

}  // namespace simplexseg
