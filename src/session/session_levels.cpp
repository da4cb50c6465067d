// SPDX-License-Identifier: Apache-2.0
// Automatic refinement of meshes, and rebuilding of meshes that deformation does not bring to their field.
#include <algorithm>
#include <string>
#include <utility>

#include "core/error.h"
#include "session/mesh_lifecycle.h"
#include "session/mesh_rebuild.h"
#include "session/mesh_sleep.h"
#include "session/scene_editor.h"
#include "session/session.h"

namespace simplexseg {
namespace {

/// Number of steps between comparisons of meshes with their fields; settled meshes are compared at the next check.
constexpr int kFitInterval = 50;
/// Number of steps after which a settled mesh may fall asleep. A mesh that was woken starts with velocity 0.
constexpr int kMinSettledSteps = 10;

}  // namespace

/// Replaces meshes of the scene and loads the engine; restores the previous meshes if loading fails. Returns whether
/// any mesh was replaced.
bool Session::load_new_meshes(NewMeshes meshes) {
  if (meshes.empty()) return false;
  const auto exchange = [&] {
    for (auto& [k, item] : meshes) std::swap(scene_.meshes[k], item);
  };
  exchange();
  try {
    load_engine();
  } catch (...) {
    exchange();
    throw;
  }
  return true;
}

LevelState Session::state_at_level(std::size_t mesh) const {
  return level_state(scene_.meshes[mesh], scene_.simulation, volume_, last_.mean_move_mm[mesh],
                     last_.mean_edge_mm[mesh]);
}

/// Whether a mesh must be compared with its field after the present step, which is one of the checks.
bool Session::is_comparison_due(std::size_t mesh) const {
  const MeshItem& item = scene_.meshes[mesh];
  if (item.locked || !uses_field(item, volume_) || !item.has_field() || item.field->is_preliminary() ||
      (item.fit.field == item.field && item.fit.settled) || is_comparing(item.id))
    return false;
  const LevelState state = state_at_level(mesh);
  const bool settled = state == LevelState::Settled;  // also with edges shrunk below a voxel on a coarser level
  if (state == LevelState::RefinementDue || (finest_[mesh] == 0 && !settled)) return false;
  return settled || total_steps_ % kFitInterval == 0;
}

/// Compares each mesh for which that is due with its field, and rebuilds it if it no longer approaches the field, or
/// starts to do so in the background. Returns whether any mesh was rebuilt.
bool Session::rebuild_stuck_meshes(const InBackground& compared, bool after_last_step) {
  NewMeshes replaced;
  for (std::size_t k = 0; k < scene_.meshes.size(); ++k) {
    if (!is_comparison_due(k)) continue;
    read_pose(k);
    if (engine_.failure()) return false;
    MeshItem& item = scene_.meshes[k];
    const std::vector<ItemId>& last = compared.after_last_step;
    if (compared.all || (after_last_step && std::find(last.begin(), last.end(), item.id) != last.end())) {
      apply(StartFieldComparison{item.id});
      continue;
    }
    FieldComparison comparison =
        compare_and_rebuild(item, state_at_level(k) == LevelState::Settled, scene_.simulation, volume_);
    if (comparison.rebuilt) {
      replaced.emplace_back(k, item);
      replace_mesh(replaced.back().second, *std::move(comparison.rebuilt));
      replaced.back().second.fit = comparison.fit;
    } else {
      item.fit = comparison.fit;
    }
  }
  return load_new_meshes(std::move(replaced));
}

ItemId Session::execute(const StartFieldComparison& command) {
  const MeshItem* const item = scene_.find_mesh(command.mesh);
  if (!item || item->locked || !uses_field(*item, volume_) || !item->has_field() || item->field->is_preliminary() ||
      is_comparing(command.mesh))
    throw Error("segmentation " + std::to_string(command.mesh),
                "there is none with that id, it is locked, it has no complete field, or it is being compared already",
                "choose another one");
  const std::size_t k = item - scene_.meshes.data();
  read_pose(k);
  fail_over_if_failed();
  field_comparer_.start(*item, state_at_level(k) == LevelState::Settled, scene_.simulation, volume_);
  return 0;
}

ItemId Session::execute(const CommitFieldComparison& command) {
  if (!is_comparing(command.mesh)) return 0;
  FieldComparison comparison = field_comparer_.finish(command.mesh);
  MeshItem& item = *scene_.find_mesh(command.mesh);
  if (!comparison.rebuilt) {
    item.fit = comparison.fit;
    return 0;
  }
  read_pose(&item - scene_.meshes.data());  // a pose that is out of date would be read into the rebuilt mesh
  fail_over_if_failed();
  MeshItem before = item;
  replace_mesh(item, *std::move(comparison.rebuilt));
  item.fit = comparison.fit;
  try {
    update_engine_or_fail_over(EngineUpdate::Meshes);
  } catch (...) {
    item = std::move(before);
    throw;
  }
  return 0;
}

/// Commits the comparisons that are complete. Returns whether a mesh was rebuilt.
bool Session::commit_complete_comparisons() {
  const std::uint64_t revision = topology_revision_;
  while (field_comparer_.ready()) apply(CommitFieldComparison{field_comparer_.first_mesh()});
  return topology_revision_ != revision;
}

/// Waits for all comparisons and commits them. Returns whether a mesh was rebuilt.
bool Session::commit_all_comparisons() {
  const std::uint64_t revision = topology_revision_;
  while (const ItemId mesh = field_comparer_.first_mesh()) apply(CommitFieldComparison{mesh});
  return topology_revision_ != revision;
}

bool Session::refine_due_meshes() {
  NewMeshes replaced;
  for (std::size_t k = 0; k < scene_.meshes.size(); ++k) {
    if (state_at_level(k) != LevelState::RefinementDue) continue;
    read_pose(k);
    if (engine_.failure()) return false;
    replaced.emplace_back(k, scene_.meshes[k]);
    refine_item(replaced.back().second);
  }
  const bool refined = load_new_meshes(std::move(replaced));
  field_comparer_.discard_useless(scene_, volume_);
  return refined;
}

/// Marks the meshes that have settled and are not being compared with their fields, and makes the next step find new
/// targets for them.
void Session::refresh_if_settled() {
  std::vector<char> may_sleep(scene_.meshes.size(), 0);
  for (std::size_t k = 0; k < scene_.meshes.size(); ++k) {
    SleepState& sleep = scene_.meshes[k].sleep;
    if (sleep.asleep) continue;
    if (state_at_level(k) != LevelState::Settled) sleep.settled_steps = 0;
    may_sleep[k] = sleep.settled_steps >= kMinSettledSteps && !is_comparing(scene_.meshes[k].id);
  }
  if (std::find(may_sleep.begin(), may_sleep.end(), 1) == may_sleep.end()) return;
  engine_->refresh();
  may_sleep_ = std::move(may_sleep);
}

/// Lets those of the marked meshes fall asleep that have not moved towards the new targets, and on which no command has
/// acted since.
void Session::put_settled_meshes_to_sleep() {
  for (std::size_t k = 0; k < scene_.meshes.size(); ++k) {
    MeshItem& item = scene_.meshes[k];
    if (may_sleep_[k] == 0 || item.sleep.settled_steps < kMinSettledSteps || is_comparing(item.id)) continue;
    if (state_at_level(k) == LevelState::Settled)
      item.sleep = {.asleep = true, .inputs = input_digest(item, scene_, volume_)};
  }
  may_sleep_.clear();
  set_engine_asleep();
}

}  // namespace simplexseg
