// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "image/volume.h"
#include "session/advance.h"
#include "session/command.h"
#include "session/engine_with_spare.h"
#include "session/field_learner.h"
#include "session/scene.h"
#include "session/step_plan.h"
#include "session/undo_history.h"

namespace simplexseg {

class DeviceError;
enum class EngineUpdate;

/// Owns the scene, the engine and the undo history; knows no Qt and no files. Every user action is a Command. The log
/// counts the steps between actions, so a replay of it depends on neither speed nor number of threads and ends in the
/// very same bits. Not thread-safe: one thread at a time, any.
class Session {
 public:
  /// `spare` makes the engine that takes over when the device of the first one fails; without it the failure is thrown.
  /// `field_threads`: on which fields are learned; 0: as many as the machine has. `fields`: how they are made; others
  /// than the program's own are for studies.
  explicit Session(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> spare = {},
                   int field_threads = 0, const EvidenceSettings& fields = {});
  ~Session();

  /// Where fields are learned from now on; the CPU until this is called. What fails there is learned on the CPU, which
  /// take_notice() says.
  void learn_fields_with(MakeBoxField make) { learner_.learn_with(std::move(make)); }

  /// Takes a new scene on a volume; the undo history is `history`, and the log empty. Meshes without a pose (no
  /// vertices) get the sphere of their seed; ids that are 0 are given. Throws Error, with nothing changed, when a
  /// mesh's seed lies outside the volume, a value is not finite or out of its table's range, a mesh is not valid, or
  /// the engine has not the memory and there is no spare. Of `history` it is expected that check_scene() takes each
  /// scene of it.
  void open(Scene scene, Volume volume, UndoHistory history = UndoHistory());
  /// Goes on with another engine, from the present poses or, where the one before was lost, those read last. Throws
  /// what the engine throws where the scene does not fit; the one before goes on then.
  void set_engine(std::unique_ptr<Engine> engine);

  /// Poses are as of the last step: they are read back from the engine when they are behind.
  const Scene& scene() const;
  /// For all who read anything but what belongs to a pose (positions of `mesh`, `previous`, `solver`): nothing is read
  /// back.
  const Scene& scene_without_poses() const { return scene_; }
  const Volume& volume() const { return volume_; }
  const Engine& engine() const { return *engine_; }
  /// For drawing alone: share_buffer, set_cells, draw_*.
  Engine& drawing() { return *engine_; }
  /// Counts the engines that the session has had: buffers shared with an earlier one are to be shared anew.
  int engine_generation() const { return engine_.generation(); }
  /// To be called with what drawing() threw: the spare engine takes over from the last poses that were read back.
  /// Throws it again when there is none.
  void lose_engine(const DeviceError& failure) { take_over(failure); }
  /// One line for the user, once: that the device failed and the session, or what it learns, goes on without it.
  std::optional<std::string> take_notice();
  /// Counts every change of connectivity: what is made from it (cells, triangles) is to be made anew.
  std::uint64_t topology_revision() const { return topology_revision_; }
  /// The plan of what the engine was loaded with; no pose is read back.
  StepPlan plan() const;

  /// Throws Error, with nothing changed, when the command cannot be carried out (no such mesh, value out of range ...).
  /// Returns the id of the item it added, else 0.
  ItemId apply(const Command& command);
  bool can_undo() const { return history_.can_undo(); }
  bool can_redo() const { return history_.can_redo(); }
  const char* undo_title() const { return history_.undo_title(); }  ///< "" when there is none
  const char* redo_title() const { return history_.redo_title(); }
  const UndoHistory& history() const { return history_; }

  /// Exactly `steps` steps (fewer at a failure or, when `stop_at_rest`, at rest). Fields whose marks have changed are
  /// learned before the first of them.
  Advance advance_steps(int steps, bool stop_at_rest = false);
  /// As many steps as fit into `seconds`; stops at rest, and, some steps later, when `enough` comes true. Fields are
  /// learned beside them, and taken between two steps.
  Advance advance(double seconds, const std::atomic<bool>* enough = nullptr);

  /// The mesh whose field is being learned beside the simulation; 0: none.
  ItemId learning() const { return learner_.learning(); }

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
  ItemId carry_out(const Undo& command);
  ItemId carry_out(const Redo& command);
  ItemId carry_out(const LearnField& command);
  ItemId carry_out(const TakeField& command);
  template <class Edit>
  ItemId carry_out(const Edit& edit);
  template <class Edit>
  ItemId edit_scene(const Edit& edit);

  void update_engine(EngineUpdate update);
  void update_engine_or_take_over(EngineUpdate update);
  void load_engine();
  void load_new_engine();
  void send_parameters();
  void send_points();
  void pull_poses() const;
  void pull_poses_or_take_over();
  void take_over(const DeviceError& failure);
  void take_over_where_lost();

  ItemId mesh_with_stale_field() const;
  void learn_all_fields();
  void learn_beside();
  void send_field(std::size_t mesh);
  Advance take_steps(int steps, bool stop_at_rest);
  using MadeMeshes = std::vector<std::pair<std::size_t, MeshItem>>;  ///< each with its place in the scene
  bool load_made(MadeMeshes made);
  void advance_on_engine(int steps, bool stop_at_rest, Advance& result);
  bool refine_where_due();
  bool rebuild_where_stuck();

  mutable EngineWithSpare engine_;
  mutable Scene scene_;
  mutable bool poses_stale_ = false;  ///< the engine has moved on from the poses of scene_
  mutable int steps_since_read_ = 0;
  Volume volume_;
  FieldLearner learner_;
  std::vector<std::string> field_warnings_;  ///< not told yet
  UndoHistory history_;
  std::vector<LogEntry> log_;
  ItemId next_id_ = 1;
  int steps_since_command_ = 0;
  std::int64_t total_steps_ = 0;
  std::uint64_t revision_ = 0, topology_revision_ = 0;
  StepOutcome last_;
  std::vector<char> finest_;  ///< whether each mesh is on its finest level, as the engine was told
  bool at_rest_ = false;
  double seconds_per_step_ = 0;
};

}  // namespace simplexseg
