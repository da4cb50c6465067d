// SPDX-License-Identifier: Apache-2.0
#include "session/session.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/error.h"
#include "core/expect.h"
#include "core/number_text.h"
#include "session/engine_scene.h"
#include "session/mesh_lifecycle.h"
#include "session/mesh_sleep.h"
#include "session/scene_checks.h"
#include "session/scene_editor.h"
#include "session/step_messages.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

/// Number of steps between checks for settling and refinement. A fixed number makes the checks independent of run time.
constexpr int kCheckInterval = 10;

/// Longest intended latency of a cancellation, in seconds; a single step may take longer.
constexpr double kMaxCancelLatencyS = 1.5e-3;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

DeviceError not_enough_memory(std::size_t needed, std::size_t available) {
  return {"the device has too little memory",
          std::to_string(needed >> 20) + " MiB needed, " + std::to_string(available >> 20) + " MiB free",
          "use --backend cpu, a smaller image or coarser meshes"};
}

/// Copy of the parts of a scene that an edit without a snapshot may change, to restore them after an error.
class EditableParts {
 public:
  explicit EditableParts(const Scene& scene)
      : points_(scene.points), measurements_(scene.measurements), layers_(scene.layers), simulation_(scene.simulation) {
    for (const MeshItem& item : scene.meshes)
      meshes_.push_back({item.parameters, item.model_profiles ? item.profiles : std::vector<float>{}, item.sleep});
  }
  void restore(Scene& scene) {
    scene.points = std::move(points_), scene.measurements = std::move(measurements_);
    scene.layers = std::move(layers_);
    scene.simulation = simulation_;
    for (std::size_t k = 0; k < scene.meshes.size(); ++k) {
      MeshItem& item = scene.meshes[k];
      item.parameters = meshes_[k].parameters, item.sleep = meshes_[k].sleep;
      if (item.model_profiles) item.profiles = std::move(meshes_[k].profiles);
    }
  }

 private:
  std::vector<UserPoint> points_;
  std::vector<Measurement> measurements_;
  std::vector<LayerItem> layers_;
  SimulationParameters simulation_;
  struct MeshParts {
    ForceParameters parameters;
    std::vector<float> profiles;  ///< only those of a model, which depend on the parameters
    SleepState sleep;
  };
  std::vector<MeshParts> meshes_;
};

}  // namespace

Session::Session(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> make_fallback,
                 int field_threads, const EvidenceSettings& fields)
    : engine_(std::move(engine), std::move(make_fallback)), field_updater_(field_threads, fields) {
  scene_.simulation = default_simulation_parameters();
}
Session::~Session() = default;

std::optional<std::string> Session::pop_notice() {
  std::optional<std::string> notice = engine_.pop_notice();
  return notice ? notice : field_updater_.pop_notice();
}

const Scene& Session::scene() const {
  read_poses();
  return scene_;
}

StepPlan Session::plan() const { return make_plan(scene_, volume_, finest_, engine_->allocated_arrays()); }

void Session::open(Scene scene, Volume volume, UndoHistory history) {
  const ItemId next_id = check_scene(scene, volume);
  for (MeshItem& item : scene.meshes) complete(item, scene.simulation, volume);
  const std::size_t needed = make_plan(scene, volume).bytes_allocated(), available = engine_->bytes_available();
  if (needed > available) engine_.fail_over(not_enough_memory(needed, available));
  std::swap(scene_, scene), std::swap(volume_, volume);
  const std::vector<char> stale = std::exchange(stale_poses_, {});
  try {
    try {
      add_paint_to_fields();
      engine_->set_volume(volume_);
      load_engine();
    } catch (const DeviceError& failure) {
      fail_over(failure);
    }
  } catch (...) {
    std::swap(scene_, scene), std::swap(volume_, volume);
    stale_poses_ = stale;
    engine_->set_volume(volume_);
    throw;
  }
  steps_since_read_ = 0;
  next_id_ = std::max(next_id, history.next_id());
  history_ = std::move(history), log_.clear();
  volume_filters_ = key_of(scene_.volume_preprocessing.filters);
  volumes_.open(scene_.volume_preprocessing.filters, volume_);
  field_updater_.open(volume_, volume_filters_), field_warnings_.clear();
  field_comparer_.discard_all();
  steps_since_command_ = 0, total_steps_ = 0, seconds_per_step_ = 0;
}

// ---- the engine ----

void Session::set_engine(std::unique_ptr<Engine> engine) {
  read_poses();
  std::unique_ptr<Engine> before = engine_.replace(std::move(engine));
  try {
    load_new_engine();
  } catch (...) {
    engine_.replace(std::move(before));
    throw;
  }
}

void Session::fail_over(const DeviceError& failure) {
  engine_.fail_over(failure);
  if (has_stale_poses() && steps_since_read_ > 0)
    engine_.append_to_notice("; the surfaces are those of " + counted(steps_since_read_, "step") + " ago");
  load_new_engine();
}

void Session::fail_over_if_failed() {
  if (engine_.failure()) fail_over(DeviceError(*engine_.failure()));
}

/// Loads a new engine with the poses that were read last.
void Session::load_new_engine() {
  stale_poses_.clear(), steps_since_read_ = 0;
  seconds_per_step_ = 0;
  engine_->set_volume(volume_);
  load_engine();
}

void Session::load_engine() {
  read_poses();
  wake_changed_meshes(scene_, volume_);
  const EngineScene loaded = engine_scene(scene_, volume_);
  engine_->load(loaded.meshes, scene_.simulation, loaded.points);
  finest_.clear();
  for (const EngineMesh& m : loaded.meshes) finest_.push_back(m.finest);
  asleep_ = sleeping_meshes(scene_), may_sleep_.clear();
  stale_poses_.assign(loaded.meshes.size(), 0);
  ++topology_revision_;
  last_ = engine_->step(0);
  ++revision_;
}

/// Loads the result of the filters of the scene, unless the volume is that result.
void Session::use_volume_filters() {
  std::string key = key_of(scene_.volume_preprocessing.filters);
  if (key == volume_filters_) return;
  volume_ = volumes_.get(scene_.volume_preprocessing.filters);
  volume_filters_ = std::move(key);
  field_updater_.open(volume_, volume_filters_);
  try {
    engine_->set_volume(volume_);
  } catch (const DeviceError& failure) {
    fail_over(failure);
  }
}

void Session::set_engine_parameters() {
  std::vector<ForceParameters> all;
  std::vector<char> finest;
  for (const MeshItem& item : scene_.meshes) {
    all.push_back(active_parameters(item, volume_));
    finest.push_back(is_finest(item, scene_.simulation, voxel_mm(volume_)));
  }
  engine_->set_parameters(all, scene_.simulation, finest);
  finest_ = std::move(finest);
}

void Session::set_engine_points() {
  engine_->set_points(engine_points(scene_));
  ++revision_;
}

void Session::update_engine(EngineUpdate update) {
  switch (update) {
    case EngineUpdate::Nothing:
      return;
    case EngineUpdate::Points:
      set_engine_points();
      return wake_meshes();
    case EngineUpdate::Parameters:
      set_engine_parameters();
      return wake_meshes();
    case EngineUpdate::Meshes:
      use_volume_filters();
      return load_engine();
  }
}

void Session::update_engine_or_fail_over(EngineUpdate update) {
  try {
    update_engine(update);
  } catch (const DeviceError& failure) {
    fail_over(failure);
    update_engine(update);
  }
}

/// Wakes the meshes on which a command acts.
void Session::wake_meshes() {
  wake_changed_meshes(scene_, volume_);
  set_engine_asleep();
}

void Session::set_engine_asleep() {
  std::vector<char> asleep = sleeping_meshes(scene_);
  if (asleep == asleep_) return;
  engine_->set_asleep(asleep);
  asleep_ = std::move(asleep);
}

bool Session::all_asleep() const {
  return std::all_of(asleep_.begin(), asleep_.end(), [](char asleep) { return asleep != 0; });
}

bool Session::has_stale_poses() const {
  return std::any_of(stale_poses_.begin(), stale_poses_.end(), [](char stale) { return stale != 0; });
}

void Session::read_pose(std::size_t mesh) const {
  if (mesh >= stale_poses_.size() || stale_poses_[mesh] == 0 || engine_.failure()) return;
  SIMPLEXSEG_EXPECT(stale_poses_.size() == scene_.meshes.size() && last_.solver.size() == stale_poses_.size());
  MeshItem& item = scene_.meshes[mesh];
  try {
    engine_->read(static_cast<int>(mesh), item.mesh.positions, item.previous);
  } catch (const DeviceError& failure) {
    // The pose that was read last remains valid; the next command or step fails over.
    engine_.record_failure(failure);
    return;
  }
  item.solver = last_.solver[mesh];
  stale_poses_[mesh] = 0;
}

void Session::read_poses() const {
  if (engine_.failure()) return;
  for (std::size_t k = 0; k < stale_poses_.size(); ++k) read_pose(k);
  if (!engine_.failure()) steps_since_read_ = 0;
}

/// Reads the current poses for a command or a snapshot, and replaces an engine that has failed.
void Session::read_poses_or_fail_over() {
  read_poses();
  fail_over_if_failed();
}

// ---- commands ----

ItemId Session::apply(const Command& command) {
  fail_over_if_failed();
  const ItemId added = std::visit([this](const auto& one) { return execute(one); }, command);
  if (std::holds_alternative<Undo>(command) || std::holds_alternative<Redo>(command) ||
      std::holds_alternative<DeleteMesh>(command))
    cancel_useless_field_update();
  if (std::holds_alternative<Undo>(command) || std::holds_alternative<Redo>(command)) field_comparer_.discard_all();
  field_comparer_.discard_useless(scene_, volume_);
  log_.push_back({steps_since_command_, command});
  steps_since_command_ = 0;
  ++revision_;
  return added;
}

ItemId Session::execute(const Undo&) {
  read_poses_or_fail_over();
  if (!history_.undo(scene_)) return 0;
  try {
    add_paint_to_fields();
    update_engine_or_fail_over(EngineUpdate::Meshes);
  } catch (...) {
    history_.redo(scene_);
    use_volume_filters();
    throw;
  }
  return 0;
}

ItemId Session::execute(const Redo&) {
  read_poses_or_fail_over();
  if (!history_.redo(scene_)) return 0;
  try {
    add_paint_to_fields();
    update_engine_or_fail_over(EngineUpdate::Meshes);
  } catch (...) {
    history_.undo(scene_);
    use_volume_filters();
    throw;
  }
  return 0;
}

template <class Edit>
ItemId Session::execute(const Edit& edit) {
  ItemId added = 0;
  if (history_.continues(edit)) {
    EditableParts before(scene_);
    try {
      added = edit_scene(edit);
    } catch (...) {
      before.restore(scene_);
      throw;
    }
  } else {
    read_poses_or_fail_over();
    const ItemId next_id = next_id_;
    UndoHistory::Snapshot before{scene_, edit};
    try {
      added = edit_scene(edit);
    } catch (...) {
      scene_ = std::move(before.scene);
      next_id_ = next_id;
      use_volume_filters();
      throw;
    }
    history_.push(std::move(before));
  }
  history_.clear_redo();
  return added;
}

template <class Edit>
ItemId Session::edit_scene(const Edit& edit) {
  const SceneChange change = SceneEditor(scene_, volume_, next_id_).execute(edit);
  if constexpr (std::is_same_v<Edit, FilterVolume>) {
    use_volume_filters();
    for (MeshItem& item : scene_.meshes) update_region(item, volume_), renew_model_profiles(item, volume_);
  }
  update_engine_or_fail_over(change.update);
  update_painted_fields();
  return change.added;
}

// ---- the simulation ----

Advance Session::advance_steps(int steps, bool stop_at_rest) {
  bool rebuilt = false;
  if (steps > 0) {
    update_all_fields();
    rebuilt = commit_all_comparisons();
  }
  Advance result = run_steps(steps, stop_at_rest, {});
  result.refined = result.refined || rebuilt;
  return result;
}

Advance Session::replay_steps(int steps, const std::vector<ItemId>& compared_after) {
  return run_steps(steps, false, {false, compared_after});
}

Advance Session::run_steps(int steps, bool stop_at_rest, const InBackground& compared) {
  SIMPLEXSEG_EXPECT(steps >= 0);
  Advance result;
  fail_over_if_failed();
  try {
    advance_on_engine(steps, stop_at_rest, compared, result);
  } catch (const DeviceError& failure) {
    fail_over(failure);
    advance_on_engine(steps, stop_at_rest, compared, result);
  }
  result.warnings = std::exchange(field_warnings_, {});
  return result;
}

void Session::advance_on_engine(int steps, bool stop_at_rest, const InBackground& compared, Advance& result) {
  const double start = now();
  while (result.steps < steps && !result.failure && !(stop_at_rest && all_asleep())) {
    const bool ends_with_sleep = !may_sleep_.empty();
    const int until_check = ends_with_sleep ? 1 : kCheckInterval - static_cast<int>(total_steps_ % kCheckInterval);
    last_ = engine_->step(std::min(steps - result.steps, until_check));
    for (std::size_t k = 0; k < scene_.meshes.size(); ++k) {
      MeshItem& item = scene_.meshes[k];
      if (item.sleep.asleep || last_.steps == 0) continue;
      stale_poses_[k] = 1;
      item.steps_at_level += last_.steps;
      item.sleep.settled_steps += last_.steps, item.sleep.awake_steps += last_.steps;
    }
    steps_since_read_ += last_.steps;
    result.steps += last_.steps;
    steps_since_command_ += last_.steps;
    total_steps_ += last_.steps;
    ++revision_;
    for (const TimestepCut& cut : last_.cuts) {
      result.cuts.push_back(text_of(cut, scene_));
      scene_.meshes[cut.failure.mesh].sleep.settled_steps = 0;  // its steps were undone: it has not settled
    }
    if (last_.failure) {
      result.failure = text_of(*last_.failure, scene_) + ", and no smaller timestep helps; lower its weight";
    } else if (ends_with_sleep) {
      put_settled_meshes_to_sleep();
    }
    if (!last_.failure && total_steps_ % kCheckInterval == 0) {
      const bool replaced = rebuild_stuck_meshes(compared, result.steps == steps) || refine_due_meshes();
      refresh_if_settled();
      result.refined = replaced || result.refined;
    }
  }
  result.at_rest = all_asleep();
  result.seconds = now() - start;
  if (result.steps > 0) seconds_per_step_ = result.seconds / result.steps;
}

Advance Session::advance(double seconds, const std::atomic<bool>* cancel) {
  Advance total;
  const double start = now();
  bool rebuilt = false;
  do {
    update_fields_in_background();
    rebuilt = commit_complete_comparisons() || rebuilt;
    const double remaining = seconds - (now() - start);
    const int affordable =
        seconds_per_step_ > 0 ? static_cast<int>(std::clamp(remaining / seconds_per_step_, 1.0, 1e6)) : 1;
    int max_steps = kCheckInterval;
    for (const int fewer : {5, 2, 1})
      if (cancel && max_steps * seconds_per_step_ > kMaxCancelLatencyS) max_steps = fewer;
    const Advance part = run_steps(std::min(affordable, max_steps), true, {true, {}});
    append(total, part);
    if (part.steps == 0 || (cancel && *cancel)) break;
  } while (!total.at_rest && !total.failure && now() - start + seconds_per_step_ < seconds);
  if (field_updater_.solving_mesh() != 0 || field_comparer_.first_mesh() != 0) total.at_rest = false;
  total.refined = total.refined || rebuilt;
  total.seconds = now() - start;
  return total;
}

}  // namespace simplexseg
