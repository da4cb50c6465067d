// SPDX-License-Identifier: Apache-2.0
#include "session/session.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/error.h"
#include "core/expect.h"
#include "session/engine_scene.h"
#include "session/mesh_life.h"
#include "session/mesh_marks.h"
#include "session/scene_checks.h"
#include "session/scene_editor.h"
#include "session/step_messages.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

/// Rest and refinement are decided at every kCheckInterval-th step, so that they depend on the count of steps alone.
constexpr int kCheckInterval = 10;

/// Who may say that it is enough waits about that long at most.
constexpr double kPatienceS = 1.5e-3;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

DeviceError not_enough_memory(std::size_t needed, std::size_t available) {
  return {"memory of the device",
          std::to_string(needed >> 20) + " MiB are needed and " + std::to_string(available >> 20) + " MiB can be had",
          "use --backend cpu, a smaller volume or coarser meshes"};
}

/// What an edit that needs no snapshot may change.
class Settings {
 public:
  explicit Settings(const Scene& scene) : points_(scene.points), simulation_(scene.simulation) {
    for (const MeshItem& item : scene.meshes) parameters_.push_back(item.parameters);
  }
  void put_back(Scene& scene) {
    scene.points = std::move(points_), scene.simulation = simulation_;
    for (std::size_t k = 0; k < scene.meshes.size(); ++k) scene.meshes[k].parameters = parameters_[k];
  }

 private:
  std::vector<UserPoint> points_;
  SimulationParameters simulation_;
  std::vector<ForceParameters> parameters_;
};

}  // namespace

Session::Session(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> spare, int field_threads,
                 const EvidenceSettings& fields)
    : engine_(std::move(engine), std::move(spare)), learner_(field_threads, fields) {
  scene_.simulation = default_simulation_parameters();
}
Session::~Session() = default;

std::optional<std::string> Session::take_notice() {
  std::optional<std::string> notice = engine_.take_notice();
  return notice ? notice : learner_.take_notice();
}

const Scene& Session::scene() const {
  pull_poses();
  return scene_;
}

StepPlan Session::plan() const { return make_plan(scene_, volume_, finest_, engine_->held_arrays()); }

void Session::open(Scene scene, Volume volume, UndoHistory history) {
  const ItemId next_id = check_scene(scene, volume);
  for (MeshItem& item : scene.meshes) complete(item, scene.simulation, volume);
  const std::size_t needed = make_plan(scene, volume).bytes_held(), available = engine_->bytes_available();
  if (needed > available) engine_.put_spare_in_place(not_enough_memory(needed, available));
  std::swap(scene_, scene), std::swap(volume_, volume);
  const bool stale = std::exchange(poses_stale_, false);
  try {
    try {
      engine_->set_volume(volume_);
      load_engine();
    } catch (const DeviceError& failure) {
      take_over(failure);
    }
  } catch (...) {
    std::swap(scene_, scene), std::swap(volume_, volume);
    poses_stale_ = stale;
    engine_->set_volume(volume_);
    throw;
  }
  steps_since_read_ = 0;
  next_id_ = std::max(next_id, history.next_id());
  history_ = std::move(history), log_.clear();
  learner_.open(volume_), field_warnings_.clear();
  steps_since_command_ = 0, total_steps_ = 0, seconds_per_step_ = 0;
}

// ---- the engine ----

void Session::set_engine(std::unique_ptr<Engine> engine) {
  pull_poses();
  std::unique_ptr<Engine> before = engine_.replace(std::move(engine));
  try {
    load_new_engine();
  } catch (...) {
    engine_.replace(std::move(before));
    throw;
  }
}

void Session::take_over(const DeviceError& failure) {
  engine_.put_spare_in_place(failure);
  if (poses_stale_ && steps_since_read_ > 0)
    engine_.add_to_notice("; the poses are those of " + std::to_string(steps_since_read_) + " steps ago");
  load_new_engine();
}

void Session::take_over_where_lost() {
  if (engine_.loss()) take_over(DeviceError(*engine_.loss()));
}

/// A new engine starts from the poses that were read last.
void Session::load_new_engine() {
  poses_stale_ = false, steps_since_read_ = 0;
  seconds_per_step_ = 0;
  engine_->set_volume(volume_);
  load_engine();
}

void Session::load_engine() {
  pull_poses();
  const EngineScene loaded = engine_scene(scene_, volume_);
  engine_->load(loaded.meshes, scene_.simulation, loaded.points);
  finest_.clear();
  for (const EngineMesh& m : loaded.meshes) finest_.push_back(m.finest);
  ++topology_revision_;
  last_ = {};
  const std::size_t meshes = loaded.meshes.size();
  last_.mean_edge_mm.assign(meshes, 0.0f);
  last_.mean_move_mm.assign(meshes, 0.0f);
  last_.residual_mm.assign(meshes, 0.0f);
  last_.folded_vertices.assign(meshes, 0);
  last_.inside_out.assign(meshes, 0);
  at_rest_ = false;
  ++revision_;
}

void Session::send_parameters() {
  std::vector<ForceParameters> all;
  std::vector<char> finest;
  for (const MeshItem& item : scene_.meshes) {
    all.push_back(parameters_in_use(item, volume_));
    finest.push_back(is_finest(item, scene_.simulation, voxel_mm(volume_)));
  }
  engine_->set_parameters(all, scene_.simulation, finest);
  finest_ = std::move(finest);
  at_rest_ = false;
}

void Session::send_field(std::size_t mesh) {
  const MeshItem& item = scene_.meshes[mesh];
  if (item.has_field()) engine_->set_field(static_cast<int>(mesh), {item.field->box, item.field->values});
}

void Session::send_points() {
  engine_->set_points(engine_points(scene_));
  at_rest_ = false;
  ++revision_;
}

void Session::update_engine(EngineUpdate update) {
  switch (update) {
    case EngineUpdate::Nothing:
      return;
    case EngineUpdate::Points:
      return send_points();
    case EngineUpdate::Parameters:
      return send_parameters();
    case EngineUpdate::Meshes:
      return load_engine();
  }
}

void Session::update_engine_or_take_over(EngineUpdate update) {
  try {
    update_engine(update);
  } catch (const DeviceError& failure) {
    take_over(failure);
    update_engine(update);
  }
}

void Session::pull_poses() const {
  if (!poses_stale_ || engine_.loss()) return;
  SIMPLEXSEG_EXPECT(last_.solver.size() == scene_.meshes.size());
  try {
    for (std::size_t k = 0; k < scene_.meshes.size(); ++k) {
      MeshItem& item = scene_.meshes[k];
      engine_->read(static_cast<int>(k), item.mesh.positions, item.previous);
      item.solver = last_.solver[k];
    }
  } catch (const DeviceError& failure) {
    // The poses that were read last stay; whoever moves the session on puts the spare engine in place.
    engine_.note_loss(failure);
    return;
  }
  poses_stale_ = false, steps_since_read_ = 0;
}

/// What a command changes, and a snapshot keeps, are poses that an engine has.
void Session::pull_poses_or_take_over() {
  pull_poses();
  take_over_where_lost();
}

// ---- commands ----

ItemId Session::apply(const Command& command) {
  take_over_where_lost();
  const ItemId added = std::visit([this](const auto& one) { return carry_out(one); }, command);
  log_.push_back({steps_since_command_, command});
  steps_since_command_ = 0;
  ++revision_;
  return added;
}

ItemId Session::carry_out(const Undo&) {
  pull_poses_or_take_over();
  if (!history_.undo(scene_)) return 0;
  try {
    update_engine_or_take_over(EngineUpdate::Meshes);
  } catch (...) {
    history_.redo(scene_);
    throw;
  }
  return 0;
}

ItemId Session::carry_out(const Redo&) {
  pull_poses_or_take_over();
  if (!history_.redo(scene_)) return 0;
  try {
    update_engine_or_take_over(EngineUpdate::Meshes);
  } catch (...) {
    history_.undo(scene_);
    throw;
  }
  return 0;
}

ItemId Session::carry_out(const LearnField& command) {
  const MeshItem* const item = scene_.find_mesh(command.mesh);
  if (!item || volume_.empty() || learner_.learning() != 0)
    throw Error("field of mesh " + std::to_string(command.mesh),
                "there is no such mesh, no volume, or another field is being learned", "take that one first");
  learner_.begin(*item, marks_of(scene_, *item, volume_), marks_of_others(scene_, *item, volume_));
  return 0;
}

ItemId Session::carry_out(const TakeField&) {
  if (learner_.learning() == 0) throw Error("field of a mesh", "none is being learned", "begin to learn one first");
  MeshItem* const item = scene_.find_mesh(learner_.learning());
  const std::shared_ptr<const MeshField> field = learner_.take();
  learner_.forget_others(scene_);
  if (!item) return 0;
  const bool waited = waits_for_field(*item, volume_);
  const std::shared_ptr<const MeshField> before = std::exchange(item->field, field);
  const std::string name = "mesh '" + item->name + "'";
  if (!field->problem.empty()) field_warnings_.push_back(name + ": its object cannot be learned: " + field->problem);
  if (field->leaks)
    field_warnings_.push_back(name +
                              " leaks: what looks like its object has no end nearby; mark what is outside of it");
  else if (field->unsure() && !(before && before->unsure()))
    field_warnings_.push_back(name +
                              " is unsure of its object: little of it is likely to be right; mark what is inside " +
                              "and outside of it");
  const std::size_t k = item - scene_.meshes.data();
  try {
    send_field(k);
    if (waited) send_parameters();
  } catch (const DeviceError& failure) {
    take_over(failure);  // which sends all
  } catch (...) {
    item->field = before;
    throw;
  }
  at_rest_ = false;
  return 0;
}

template <class Edit>
ItemId Session::carry_out(const Edit& edit) {
  ItemId added = 0;
  if (history_.continues(edit)) {
    Settings before(scene_);
    try {
      added = edit_scene(edit);
    } catch (...) {
      before.put_back(scene_);
      throw;
    }
  } else {
    pull_poses_or_take_over();
    const ItemId next_id = next_id_;
    UndoHistory::Snapshot before{scene_, edit};
    try {
      added = edit_scene(edit);
    } catch (...) {
      scene_ = std::move(before.scene);
      next_id_ = next_id;
      throw;
    }
    history_.keep(std::move(before));
  }
  history_.forget_undone();
  return added;
}

template <class Edit>
ItemId Session::edit_scene(const Edit& edit) {
  const SceneChange change = SceneEditor(scene_, volume_, next_id_).carry_out(edit);
  update_engine_or_take_over(change.update);
  return change.added;
}

// ---- the simulation ----

ItemId Session::mesh_with_stale_field() const {
  for (const MeshItem& item : scene_.meshes)
    if (!item.locked && has_stale_field(scene_, item, volume_)) return item.id;
  return 0;
}

void Session::learn_all_fields() {
  if (learner_.learning() != 0) apply(TakeField{});
  while (const ItemId mesh = mesh_with_stale_field()) apply(LearnField{mesh}), apply(TakeField{});
}

void Session::learn_beside() {
  if (learner_.ready()) apply(TakeField{});
  if (learner_.learning() != 0) return;
  if (const ItemId mesh = mesh_with_stale_field()) apply(LearnField{mesh});
}

Advance Session::advance_steps(int steps, bool stop_at_rest) {
  if (steps > 0) learn_all_fields();
  return take_steps(steps, stop_at_rest);
}

Advance Session::take_steps(int steps, bool stop_at_rest) {
  SIMPLEXSEG_EXPECT(steps >= 0);
  Advance result;
  take_over_where_lost();
  try {
    advance_on_engine(steps, stop_at_rest, result);
  } catch (const DeviceError& failure) {
    take_over(failure);
    advance_on_engine(steps, stop_at_rest, result);
  }
  result.warnings = std::exchange(field_warnings_, {});
  return result;
}

void Session::advance_on_engine(int steps, bool stop_at_rest, Advance& result) {
  const double start = now();
  while (result.steps < steps && !result.failure && !(stop_at_rest && at_rest_)) {
    const int until_check = kCheckInterval - static_cast<int>(total_steps_ % kCheckInterval);
    last_ = engine_->step(std::min(steps - result.steps, until_check));
    poses_stale_ = true;
    steps_since_read_ += last_.steps;
    result.steps += last_.steps;
    steps_since_command_ += last_.steps;
    total_steps_ += last_.steps;
    ++revision_;
    for (MeshItem& item : scene_.meshes) item.steps_at_level += last_.steps;
    for (const TimestepCut& cut : last_.cuts) result.cuts.push_back(text_of(cut, scene_));
    if (last_.failure) {
      result.failure = text_of(*last_.failure, scene_) + ", and no smaller timestep helps: lower its weight";
    } else if (total_steps_ % kCheckInterval == 0) {
      result.refined = rebuild_where_stuck() || refine_where_due() || result.refined;
    }
  }
  result.at_rest = at_rest_;
  result.seconds = now() - start;
  if (result.steps > 0) seconds_per_step_ = result.seconds / result.steps;
}

Advance Session::advance(double seconds, const std::atomic<bool>* enough) {
  Advance total;
  const double start = now();
  do {
    learn_beside();
    const double left = seconds - (now() - start);
    const int fit = seconds_per_step_ > 0 ? static_cast<int>(std::clamp(left / seconds_per_step_, 1.0, 1e6)) : 1;
    int most = kCheckInterval;
    for (const int fewer : {5, 2, 1})
      if (enough && most * seconds_per_step_ > kPatienceS) most = fewer;
    const Advance part = take_steps(std::min(fit, most), true);
    append(total, part);
    if (part.steps == 0 || (enough && *enough)) break;
  } while (!total.at_rest && !total.failure && now() - start + seconds_per_step_ < seconds);
  if (learner_.learning() != 0) total.at_rest = false;
  total.seconds = now() - start;
  return total;
}

void Session::replay(const std::vector<LogEntry>& log, int trailing_steps) {
  // A log that was recorded says when fields were learned; in one that was written by hand they are when they can be.
  const bool tells = std::any_of(
      log.begin(), log.end(), [](const LogEntry& entry) { return std::holds_alternative<LearnField>(entry.command); });
  // A failure ended what was asked for, not the session.
  const auto advance_by = [&](int steps) {
    for (int done = 0; done < steps;)
      done += (tells ? take_steps(steps - done, false) : advance_steps(steps - done)).steps;
  };
  for (const LogEntry& entry : log) {
    advance_by(entry.steps);
    apply(entry.command);
  }
  advance_by(trailing_steps);
}

}  // namespace simplexseg
