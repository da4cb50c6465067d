// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "session/command.h"
#include "session/scene.h"

namespace simplexseg {

/// What can be taken back and done again: whole scenes, poses included, for undo is an exchange of scenes
/// (docs/adr/0007-undo-by-snapshot.md). At most 200 are kept for undo, and no more than about 1 GiB of them.
class UndoHistory {
 public:
  /// The scene as it was before the command.
  struct Snapshot {
    Scene scene;
    Command command;
  };

  bool can_undo() const { return !undo_.empty(); }
  bool can_redo() const { return !redo_.empty(); }
  const char* undo_title() const;  ///< "" when there is none
  const char* redo_title() const;

  /// Whether the command goes on with the drag or the slider movement that the last snapshot precedes: the two are
  /// taken back together, so no snapshot is due.
  bool continues(const Command& command) const;
  /// Keeps a snapshot of before a command that was carried out.
  void keep(Snapshot before);
  /// A new command was carried out: what was taken back before it cannot be done again.
  void forget_undone() { redo_.clear(); }
  void clear();

  /// Exchange the scene for that before the last command, or after the one taken back last. False, with nothing
  /// changed, when there is none.
  bool undo(Scene& scene) { return exchange(scene, undo_, redo_); }
  bool redo(Scene& scene) { return exchange(scene, redo_, undo_); }

 private:
  static bool exchange(Scene& scene, std::vector<Snapshot>& from, std::vector<Snapshot>& to);

  std::vector<Snapshot> undo_, redo_;
};

}  // namespace simplexseg
