// SPDX-License-Identifier: Apache-2.0
// Automatic refinement of meshes, and rebuilding of meshes that deformation does not bring to their field.
#include <algorithm>
#include <limits>
#include <utility>

#include "session/mesh_lifecycle.h"
#include "session/mesh_rebuild.h"
#include "session/mesh_sleep.h"
#include "session/session.h"

namespace simplexseg {
namespace {

/// Number of steps between comparisons of meshes with their fields; settled meshes are compared at the next check.
constexpr int kFitInterval = 50;
/// Share of the previous disagreement; a mesh is stuck if more than this share remains after an interval.
constexpr double kStuckShare = 0.8;
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

/// Rebuilds each mesh that no longer approaches its field from that field. Returns whether any mesh was rebuilt.
bool Session::rebuild_stuck_meshes() {
  NewMeshes replaced;
  for (std::size_t k = 0; k < scene_.meshes.size(); ++k) {
    MeshItem& item = scene_.meshes[k];
    if (item.locked || !uses_field(item, volume_) || !item.has_field() || item.field->is_preliminary() ||
        (item.fit.field == item.field && item.fit.settled))
      continue;
    const LevelState state =
        level_state(item, scene_.simulation, volume_, last_.mean_move_mm[k], last_.mean_edge_mm[k]);
    const bool settled = state == LevelState::Settled;  // also with edges shrunk below a voxel on a coarser level
    if (state == LevelState::RefinementDue || (finest_[k] == 0 && !settled)) continue;
    if (total_steps_ % kFitInterval != 0 && !settled) continue;
    read_pose(k);
    if (engine_.failure()) return false;
    const int before = item.fit.field == item.field ? item.fit.disagreement : std::numeric_limits<int>::max();
    const FieldMismatch mismatch = compare_with_field(item, volume_);
    const bool stuck = !mismatch.matches() && mismatch.disagreement() > kStuckShare * before;
    const FieldFit fit{item.field, mismatch.disagreement(), settled || stuck};
    if (!mismatch.matches() && fit.settled) {
      MeshItem rebuilt = item;
      rebuilt.fit = fit;
      if (rebuild_from_field(rebuilt, scene_.simulation, volume_) &&
          compare_with_field(rebuilt, volume_).better_than(mismatch)) {
        replaced.emplace_back(k, std::move(rebuilt));
        continue;  // the new mesh contains `fit`
      }
    }
    item.fit = fit;
  }
  return load_new_meshes(std::move(replaced));
}

bool Session::refine_due_meshes() {
  NewMeshes replaced;
  for (std::size_t k = 0; k < scene_.meshes.size(); ++k) {
    const MeshItem& item = scene_.meshes[k];
    const LevelState state =
        level_state(item, scene_.simulation, volume_, last_.mean_move_mm[k], last_.mean_edge_mm[k]);
    if (state != LevelState::RefinementDue) continue;
    read_pose(k);
    if (engine_.failure()) return false;
    replaced.emplace_back(k, item);
    refine_item(replaced.back().second);
  }
  return load_new_meshes(std::move(replaced));
}

/// Marks the meshes that have settled, and makes the next step find new targets for them.
void Session::refresh_if_settled() {
  std::vector<char> may_sleep(scene_.meshes.size(), 0);
  for (std::size_t k = 0; k < scene_.meshes.size(); ++k) {
    SleepState& sleep = scene_.meshes[k].sleep;
    if (sleep.asleep) continue;
    if (level_state(scene_.meshes[k], scene_.simulation, volume_, last_.mean_move_mm[k], last_.mean_edge_mm[k]) !=
        LevelState::Settled)
      sleep.settled_steps = 0;
    may_sleep[k] = sleep.settled_steps >= kMinSettledSteps;
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
    if (may_sleep_[k] == 0 || item.sleep.settled_steps < kMinSettledSteps) continue;
    if (level_state(item, scene_.simulation, volume_, last_.mean_move_mm[k], last_.mean_edge_mm[k]) ==
        LevelState::Settled)
      item.sleep = {true, 0, input_digest(item, scene_, volume_)};
  }
  may_sleep_.clear();
  set_engine_asleep();
}

}  // namespace simplexseg
