// SPDX-License-Identifier: Apache-2.0
// What a session makes anew of its meshes by itself: refined ones, and those that are stuck.
#include <limits>
#include <utility>

#include "session/mesh_life.h"
#include "session/mesh_rebuild.h"
#include "session/session.h"

namespace simplexseg {
namespace {

/// Whether meshes follow their fields is looked at every kFitInterval steps, and where they rest.
constexpr int kFitInterval = 50;
constexpr double kLeastProgress = 0.8;  // of the disagreement before

}  // namespace

/// Puts meshes in the place of those that are there and loads them; when that is not possible, those that were there
/// stay. Returns whether there are any.
bool Session::load_made(MadeMeshes made) {
  if (made.empty()) return false;
  const auto exchange = [&] {
    for (auto& [k, item] : made) std::swap(scene_.meshes[k], item);
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

/// A mesh that no longer comes nearer to what its field says is made of the field.
bool Session::rebuild_where_stuck() {
  MadeMeshes all;
  for (std::size_t k = 0; k < scene_.meshes.size(); ++k) {
    MeshItem& item = scene_.meshes[k];
    if (item.locked || !takes_field(item, volume_) || !item.has_field() ||
        (item.fit.field == item.field && item.fit.settled))
      continue;
    const LevelState state =
        level_state(item, scene_.simulation, volume_, last_.mean_move_mm[k], last_.mean_edge_mm[k]);
    const bool rests = state == LevelState::Rests;  // or fell together below a voxel before its finest level
    if (state == LevelState::Due || (finest_[k] == 0 && !rests)) continue;
    if (total_steps_ % kFitInterval != 0 && !rests) continue;
    pull_poses();
    if (engine_.loss()) return false;
    const int before = item.fit.field == item.field ? item.fit.disagreement : std::numeric_limits<int>::max();
    const FieldDistance distance = distance_to_field(item, volume_);
    const bool stuck = !distance.follows() && distance.disagreement() > kLeastProgress * before;
    const FieldFit fit{item.field, distance.disagreement(), rests || stuck};
    if (!distance.follows() && fit.settled) {
      MeshItem made = item;
      made.fit = fit;
      if (rebuild_from_field(made, scene_.simulation, volume_) &&
          distance_to_field(made, volume_).nearer_than(distance)) {
        all.emplace_back(k, std::move(made));
        continue;  // settled once it is loaded
      }
    }
    item.fit = fit;
  }
  return load_made(std::move(all));
}

bool Session::refine_where_due() {
  MadeMeshes all;
  bool rests = true;
  for (std::size_t k = 0; k < scene_.meshes.size(); ++k) {
    const MeshItem& item = scene_.meshes[k];
    const LevelState state =
        level_state(item, scene_.simulation, volume_, last_.mean_move_mm[k], last_.mean_edge_mm[k]);
    if (state != LevelState::Rests) rests = false;
    if (state != LevelState::Due) continue;
    pull_poses();
    if (engine_.loss()) return false;
    all.emplace_back(k, item);
    refine_item(all.back().second);
  }
  at_rest_ = rests;
  return load_made(std::move(all));
}

}  // namespace simplexseg
