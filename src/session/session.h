// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "image/volume.h"
#include "session/command.h"
#include "session/scene.h"
#include "session/step_plan.h"
#include "step/engine.h"

namespace simplexseg {

class DeviceError;

/// What an advance did.
struct Advance {
  int steps = 0;
  double seconds = 0;
  bool at_rest = false;                ///< nothing moves any more: no need to be called again until something changes
  std::vector<std::string> cuts;       ///< one line for each step that was undone and its mesh's timestep cut
  std::optional<std::string> failure;  ///< one line naming mesh and force; the step was undone, the run should pause
  bool refined = false;                ///< the vertex counts have changed
};

/// Owns the scene, the engine and the undo history; knows no Qt and no files. Every user action is a Command. The log
/// counts the steps between actions, so a replay of it depends on neither speed nor number of threads and ends in the
/// very same bits. Not thread-safe: one thread at a time.
class Session {
 public:
  /// `spare` makes the engine that takes over when the device of the first one fails; without it the failure is thrown.
  explicit Session(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> spare = {});
  ~Session();

  /// Takes a new scene (undo history and log are dropped) on a volume. Meshes without a pose (no vertices) get the
  /// sphere of their seed; ids that are 0 are given. Throws Error, with nothing changed, when a mesh's seed lies
  /// outside the volume, a value is not finite or out of its table's range, or a mesh is not valid.
  void open(Scene scene, Volume volume);
  /// As open; Error also when the engine has not the memory for it and there is no spare.
  void set_engine(std::unique_ptr<Engine> engine);

  /// Poses are as of the last step: they are read back from the engine when they are behind.
  const Scene& scene() const;
  /// For all who read anything but poses (positions of `mesh`, `previous`): nothing is read back.
  const Scene& scene_without_poses() const { return scene_; }
  const Volume& volume() const { return volume_; }
  const Engine& engine() const { return *engine_; }
  /// For drawing alone: share_buffer, set_cells, draw_*.
  Engine& drawing() { return *engine_; }
  /// Counts the engines that the session has had: buffers shared with an earlier one are to be shared anew.
  int engine_generation() const { return engine_generation_; }
  /// To be called with what drawing() threw: the spare engine takes over from the last poses that were read back.
  /// Throws it again when there is none.
  void lose_engine(const DeviceError& failure) { take_over(failure); }
  /// One line for the user, once: that the device failed and the session goes on without it.
  std::optional<std::string> take_notice() { return std::exchange(notice_, std::nullopt); }
  /// Counts every change of connectivity: what is made from it (cells, triangles) is to be made anew.
  std::uint64_t topology_revision() const { return topology_revision_; }
  /// Of what the engine was loaded with; no pose is read back.
  StepPlan plan() const;

  /// Throws Error, with nothing changed, when the command cannot be carried out (no such mesh, value out of range ...).
  /// Returns the id of the item it added, else 0.
  ItemId apply(const Command& command);
  bool can_undo() const { return !undo_.empty(); }
  bool can_redo() const { return !redo_.empty(); }
  const char* undo_title() const;  ///< "" when there is none
  const char* redo_title() const;

  /// Exactly `steps` steps (fewer at a failure or, when `stop_at_rest`, at rest).
  Advance advance_steps(int steps, bool stop_at_rest = false);
  /// As many steps as fit into `seconds`; stops at rest.
  Advance advance(double seconds);

  const std::vector<LogEntry>& log() const { return log_; }
  int steps_since_last_command() const { return steps_since_command_; }
  std::int64_t total_steps() const { return total_steps_; }
  /// Repeats a log on the present scene; `trailing_steps` further steps at its end.
  void replay(const std::vector<LogEntry>& log, int trailing_steps);
  /// Counts every change of scene or pose: what a view compares to know whether it is dirty.
  std::uint64_t revision() const { return revision_; }
  /// Motion of each mesh in the last step, mm.
  const std::vector<float>& mean_move_mm() const { return last_.mean_move_mm; }
  /// What was measured of each mesh after the last steps.
  const StepOutcome& last_outcome() const { return last_; }

 private:
  struct Snapshot {
    Scene scene;
    Command command;
  };
  ItemId carry_out(const Command& command);
  ItemId carry_out_add(const AddMesh& command);
  bool continues_last(const Command& command) const;
  void step_back(std::vector<Snapshot>& from, std::vector<Snapshot>& to);
  void load_engine();
  void send_points();
  void pull_poses() const;
  bool is_finest(const MeshItem& item) const;
  double voxel_mm() const;
  bool refine_where_due();
  void refine_item(MeshItem& item);
  void restart(MeshItem& item);
  void record_profiles(MeshItem& item) const;
  MeshItem& item_of(ItemId mesh);                ///< throws Error when there is none
  std::vector<MeshItem*> items_of(ItemId mesh);  ///< 0: all; throws Error when there is no such mesh

  std::string culprit_text(const StepFailure& failure) const;
  void replace_engine(const DeviceError& failure);
  void take_over(const DeviceError& failure);
  void advance_on_engine(int steps, bool stop_at_rest, Advance& result);
  ItemId carry_out_or_take_over(const Command& command);

  std::unique_ptr<Engine> engine_;
  std::function<std::unique_ptr<Engine>()> spare_;
  mutable std::optional<std::string> notice_,
      lost_;  ///< lost_: what the engine failed with, until the spare is in place
  mutable int steps_since_read_ = 0;
  int engine_generation_ = 0;
  std::uint64_t topology_revision_ = 0;
  mutable Scene scene_;
  mutable bool poses_stale_ = false;  ///< the engine has moved on from the poses of scene_
  Volume volume_;
  std::vector<Snapshot> undo_, redo_;
  std::vector<LogEntry> log_;
  ItemId next_id_ = 1;
  int steps_since_command_ = 0;
  std::int64_t total_steps_ = 0;
  std::uint64_t revision_ = 0;
  StepOutcome last_;
  std::vector<char> finest_;  ///< of each mesh, as the engine was told
  bool at_rest_ = false;
  double seconds_per_step_ = 0;
};

}  // namespace simplexseg
