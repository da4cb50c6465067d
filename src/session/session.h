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
#include "session/failover_engine.h"
#include "session/field_comparer.h"
#include "session/field_updater.h"
#include "session/filtered_volumes.h"
#include "session/scene.h"
#include "session/step_plan.h"
#include "session/undo_history.h"

namespace simplexseg {

class DeviceError;
enum class EngineUpdate;
enum class LevelState;

/// Owner of scene, engine and undo history; independent of Qt and of files. Every user action is a Command. The log
/// records the number of steps between actions, so a replay gives the same bits at any speed and with any number of
/// threads. Not thread-safe: any thread may call it, but only one thread at a time.
class Session {
 public:
  /// `make_fallback`: makes the engine that replaces the first one when its device fails; empty: failures are thrown.
  /// `field_threads`: number of threads that solve fields; 0: as many as the machine has. `fields`: settings of the
  /// fields; only studies change them.
  explicit Session(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> make_fallback = {},
                   int field_threads = 0, const EvidenceSettings& fields = {});
  ~Session();

  /// Sets the solver of the fields that are created from now on; default: the CPU solver. If its device fails, the CPU
  /// takes over and pop_notice() reports it.
  void set_field_solver(MakeFieldSolver make) { field_updater_.set_solver(std::move(make)); }

  /// Sets the source of the images of layers in which fields are solved (MeshItem::images).
  void set_layer_source(LayerOnGrid source) { field_updater_.set_layer_source(std::move(source)); }

  /// Opens a scene on a volume, with this undo history and an empty log. Meshes without vertices get the sphere of
  /// their seed or their start; meshes and points whose id is 0 get an id. Throws Error, with nothing changed, for a
  /// seed outside the volume, a value that is not finite or out of range, an invalid mesh, or too little memory without
  /// a fallback engine. Every scene of `history` must pass check_scene(). `volume`: after Scene::volume_preprocessing.
  void open(Scene scene, Volume volume, UndoHistory history = UndoHistory());
  /// Adds a result of filters on the volume of the open scene, for commands, undo and redo (FilteredVolumes).
  void add_volume(FilteredVolume result) { volumes_.add(std::move(result)); }
  const FilteredVolumes& volumes() const { return volumes_; }
  /// Sets the function that computes results that were not added.
  void set_volume_filter(ApplyFilter apply) { volumes_.set_filter(std::move(apply)); }
  /// Replaces the engine. Loads the current poses or, if the previous engine failed, those downloaded last. Rethrows
  /// errors of the new engine, for example if the scene does not fit into its memory; the session then keeps the
  /// previous engine.
  void set_engine(std::unique_ptr<Engine> engine);

  /// Scene with the poses after the last step, which are downloaded from the engine if necessary. If the engine fails,
  /// the poses are those downloaded last.
  const Scene& scene() const;
  /// Scene whose poses (positions of `mesh`, `previous`, `solver`) may be out of date; downloads nothing.
  const Scene& scene_without_poses() const { return scene_; }
  const Volume& volume() const { return volume_; }
  const Engine& engine() const { return *engine_; }
  /// Engine, only for drawing: share_buffer, set_cells, draw_*.
  Engine& drawing() { return *engine_; }
  /// Number of engines before the current one; buffers must be shared again when it changes.
  int engine_generation() const { return engine_.generation(); }
  /// Replaces the engine with the fallback after a failure, for example of drawing(), and continues from the poses
  /// downloaded last. Without a fallback, throws `failure`.
  void fail_over(const DeviceError& failure);
  /// Removes and returns the message to the user that the device of the engine or of the fields failed and the CPU
  /// replaces it.
  std::optional<std::string> pop_notice();
  /// Counter that changes whenever the connectivity of a mesh may have changed; cells and triangles must then be
  /// rebuilt.
  std::uint64_t topology_revision() const { return topology_revision_; }
  /// Plan of the loaded meshes; downloads no pose.
  StepPlan plan() const;

  /// Executes a command and logs it. Returns the id of the mesh or point that was added, else 0. Throws Error, with
  /// nothing changed, if the command cannot be executed (unknown mesh, value out of range ...).
  ItemId apply(const Command& command);
  bool can_undo() const { return history_.can_undo(); }
  bool can_redo() const { return history_.can_redo(); }
  const char* undo_title() const { return history_.undo_title(); }  ///< title_of() the command; "": none
  const char* redo_title() const { return history_.redo_title(); }
  const UndoHistory& history() const { return history_; }

  /// Solves all fields whose marks have changed and whose update was not cancelled, then runs `steps` steps; fewer
  /// after a failure or, with `stop_at_rest`, once all meshes have settled. Meshes are compared with their fields
  /// between two steps.
  Advance advance_steps(int steps, bool stop_at_rest = false);
  /// Runs as many steps as fit into `seconds`. Stops once all meshes have settled, and a few steps after `cancel` (may
  /// be null) becomes true. Fields are solved, and meshes compared with them, in the background; both are committed
  /// between two steps.
  Advance advance(double seconds, const std::atomic<bool>* cancel = nullptr);

  /// Mesh whose field is being solved in the background; 0: none.
  ItemId solving_mesh() const { return field_updater_.solving_mesh(); }
  /// Completed fraction of the field that is being solved, 0 to 1; 0 if no field is being solved.
  float solving_progress() const { return field_updater_.progress(); }
  /// Stops the field that is being solved in the background; the next CommitFieldUpdate changes nothing. Not logged:
  /// call it when the session ends; CancelFieldUpdate is the action of a user. Undo, redo and the deletion of a mesh
  /// cancel a field that they make useless.
  void cancel_field_update() { field_updater_.cancel(); }
  /// Ends and logs a cancelled field update (CancelFieldUpdate), which frees its memory; without one, does nothing.
  void finish_cancelled_update() {
    if (field_updater_.cancelled()) apply(CancelFieldUpdate{});
  }

  /// Whether a mesh is being compared with its field in the background; it has then not settled.
  bool is_comparing(ItemId mesh) const { return field_comparer_.is_comparing(mesh); }
  /// Sets the function that compares meshes in the background. For tests.
  void set_field_comparison(CompareMesh compare) { field_comparer_.set_compare(std::move(compare)); }

  const std::vector<LogEntry>& log() const { return log_; }
  int steps_since_last_command() const { return steps_since_command_; }
  std::int64_t total_steps() const { return total_steps_; }
  /// Replays a log on the current scene, then runs `trailing_steps` further steps (LogReplay).
  void replay(const std::vector<LogEntry>& log, int trailing_steps);
  /// Runs steps without solving or committing fields. `compared_after`: meshes whose comparison is started in the
  /// background after the last of these steps if it is due; other comparisons are made between two steps. For
  /// LogReplay.
  Advance replay_steps(int steps, const std::vector<ItemId>& compared_after);
  /// Counter that changes with scene and poses; a view must then be redrawn.
  std::uint64_t revision() const { return revision_; }
  /// Mean motion of each mesh in the last step, mm; 0 before the first step.
  const std::vector<float>& mean_move_mm() const { return last_.mean_move_mm; }
  /// Measurements of each mesh after the last steps.
  const StepOutcome& last_outcome() const { return last_; }

 private:
  ItemId execute(const Undo& command);
  ItemId execute(const Redo& command);
  ItemId execute(const StartFieldUpdate& command);
  ItemId execute(const CommitFieldUpdate& command);
  ItemId execute(const CommitPreliminaryField& command);
  ItemId execute(const CancelFieldUpdate& command);
  ItemId execute(const RequestFieldUpdate& command);
  ItemId execute(const StartFieldComparison& command);
  ItemId execute(const CommitFieldComparison& command);
  template <class Edit>
  ItemId execute(const Edit& edit);
  template <class Edit>
  ItemId edit_scene(const Edit& edit);

  void update_engine(EngineUpdate update);
  void update_engine_or_fail_over(EngineUpdate update);
  void load_engine();
  void use_volume_filters();
  void load_new_engine();
  void set_engine_parameters();
  void set_engine_points();
  void wake_meshes();
  void set_engine_asleep();
  bool all_asleep() const;
  bool has_stale_poses() const;
  void read_pose(std::size_t mesh) const;
  void read_poses() const;
  void read_poses_or_fail_over();
  void fail_over_if_failed();

  ItemId mesh_with_due_update() const;
  void cancel_useless_field_update();
  void finish_field_update();
  void update_all_fields();
  void update_fields_in_background();
  void attach_field(MeshItem& item, std::shared_ptr<const MeshField> field);
  void add_paint_to_fields();
  void update_painted_fields();
  void set_engine_field(std::size_t mesh);
  /// Meshes whose comparisons run in the background; those of other meshes are made between two steps.
  struct InBackground {
    bool all = false;
    std::vector<ItemId> after_last_step;  ///< meshes whose comparison is started after the last step
  };
  Advance run_steps(int steps, bool stop_at_rest, const InBackground& compared);
  using NewMeshes = std::vector<std::pair<std::size_t, MeshItem>>;  ///< new meshes with their indices in the scene
  bool load_new_meshes(NewMeshes meshes);
  void advance_on_engine(int steps, bool stop_at_rest, const InBackground& compared, Advance& result);
  bool refine_due_meshes();
  LevelState state_at_level(std::size_t mesh) const;
  bool is_comparison_due(std::size_t mesh) const;
  bool rebuild_stuck_meshes(const InBackground& compared, bool after_last_step);
  bool commit_complete_comparisons();
  bool commit_all_comparisons();
  void refresh_if_settled();
  void put_settled_meshes_to_sleep();

  mutable FailoverEngine engine_;
  mutable Scene scene_;
  /// For each loaded mesh, whether the engine has moved it since its pose in scene_ was read.
  mutable std::vector<char> stale_poses_;
  mutable int steps_since_read_ = 0;
  Volume volume_;               ///< after the filters of the scene
  std::string volume_filters_;  ///< key_of() the filters of volume_
  FilteredVolumes volumes_;
  FieldUpdater field_updater_;
  FieldComparer field_comparer_;
  std::vector<std::string> field_warnings_;  ///< warnings for the next Advance
  UndoHistory history_;
  std::vector<LogEntry> log_;
  ItemId next_id_ = 1;
  int steps_since_command_ = 0;
  std::int64_t total_steps_ = 0;
  std::uint64_t revision_ = 0, topology_revision_ = 0;
  StepOutcome last_;
  std::vector<char> finest_;     ///< whether each mesh is on its finest level, as set in the engine
  std::vector<char> asleep_;     ///< whether each mesh sleeps, as set in the engine
  std::vector<char> may_sleep_;  ///< whether each mesh falls asleep unless the next step moves it; empty: none does
  double seconds_per_step_ = 0;
};

}  // namespace simplexseg
