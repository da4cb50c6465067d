// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "gpu/batch_results.h"
#include "gpu/force_arrays.h"
#include "gpu/forces_in_use.h"
#include "gpu/levels.h"
#include "gpu/mesh_arrays.h"
#include "gpu/recorded_runs.h"
#include "gpu/step_supervision.h"
#include "gpu/tiles.h"
#include "step/simulation_parameters.h"
#include "step/step_needs.h"

namespace simplexseg {

/// What an engine has of the meshes that are loaded: a load makes all of it anew, and exchanges it for what was there.
template <class Executor>
class LoadedMeshes {
 protected:
  static constexpr bool built(ForceId force) { return (kBuiltForces & bit(force)) != 0; }

  bool active(ForceId force) const { return built(force) && needs_.uses(force); }
  int refresh_interval() const { return static_cast<int>(simulation_.refresh_interval + 0.5f); }

  /// All that a change of settings changes, arrays and what they are made of apart.
  struct Settings {
    std::vector<ForceParameters> wanted;
    SimulationParameters simulation;
    StepNeeds needs;
    StepPhase phase;
    bool forms_due;
    std::vector<MeshConstants> constants;
    typename StepSupervision<Executor>::Settings supervision;
  };
  Settings settings() const {
    return {wanted_,
            simulation_,
            needs_,
            phase_,
            forms_due_,
            {meshes_.all().begin(), meshes_.all().end()},
            supervision_.settings()};
  }
  void put_back(Settings before) {
    wanted_ = std::move(before.wanted), simulation_ = before.simulation, needs_ = before.needs;
    phase_ = before.phase, forms_due_ = before.forms_due;
    meshes_.put_back(std::move(before.constants));
    forget_rest();
    supervision_.put_back(std::move(before.supervision));
    drop_what_is_not_needed();
    if (meshes_.size() != 0) meshes_.send_constants();
  }

  /// Each array is held exactly while the plan needs it. Nothing is given back before all that is needed is there.
  void hold_arrays(bool has_volume) {
    std::vector<MeshNeeds> meshes;
    for (std::size_t k = 0; k < meshes_.size(); ++k) meshes.push_back(forces_.needs_of_mesh(k, meshes_[k]));
    const StepNeeds needs = needs_of(meshes, has_volume, forces_.point_count());
    if (needs_levels()) levels_.hold(meshes_.all(), meshes_.neighbours());
    if (needs_tiles(needs)) tiles_.hold(meshes_.neighbours()), meshes_.hold_two_frames(phase_.frame);
    supervision_.make(meshes_);
    forces_.make(needs, kBuiltForces & needs.forces, meshes_);
    needs_ = needs;
    drop_what_is_not_needed();
  }

  /// Meshes on which no force acts, and that have come to rest, are left out of steps: their vertices stay where they
  /// are, bit by bit, whatever is done. True when there are more of them now: runs recorded before do not know.
  bool leave_out_what_rests(Launcher<Executor>& launcher) {
    bool more = false;
    for (std::size_t k = 0; k < meshes_.size(); ++k) {
      MeshConstants& c = meshes_[k];
      const MeshMotion& motion = results_.motion()[k];
      if (c.rests != 0 || motion.mean_move_mm != 0 || motion.square_move != 0 || acts(k)) continue;
      if (meshes_.is_still(k)) c.rests = 1, more = true;
    }
    if (!more) return false;
    meshes_.send_constants();
    launcher.executor.leave_to(acting());
    meshes_.keep_frames(launcher, phase_.frame);
    return true;
  }
  /// Before anything changes. True when something was left out.
  bool wake(Launcher<Executor>& launcher) {
    launcher.executor.leave_to({});
    return forget_rest();
  }

  /// What the forces of a mesh still asked for in the last step of a batch.
  float residual_mm(std::size_t k) {
    float weights = 0;
    for (const ForceInfo& force : force_list()) weights += active(force.id) ? meshes_[k].forces.weight(force.id) : 0.0f;
    return weights > 0 ? std::sqrt(std::max(results_.motion()[k].mean_square_force, 0.0f)) / weights : 0.0f;
  }
  void measure(std::size_t k, const MeshMotion& motion, float residual_mm, StepOutcome& outcome) const {
    outcome.mean_move_mm.push_back(motion.mean_move_mm);
    outcome.mean_edge_mm.push_back(motion.mean_edge_mm);
    outcome.residual_mm.push_back(residual_mm);
    outcome.folded_vertices.push_back(static_cast<int>(motion.folded));
    outcome.inside_out.push_back(motion.volume < 0);
    outcome.solver.push_back(supervision_.control(k).state());
  }

  std::vector<ForceParameters> wanted_;  ///< of each mesh, as set; MeshConstants has the forces that act
  SimulationParameters simulation_{};
  StepNeeds needs_;
  StepPhase phase_;
  bool forms_due_ = false;  ///< what the forms of the meshes need could not be had
  MeshArrays<Executor> meshes_;
  ForceArrays<Executor> forces_;
  StepSupervision<Executor> supervision_;
  CoarseLevels<Executor> levels_;
  Tiles<Executor> tiles_;
  BatchResults<Executor> results_;

 private:
  bool forget_rest() {
    bool some = false;
    for (std::size_t k = 0; k < meshes_.size(); ++k) some = std::exchange(meshes_[k].rests, 0) != 0 || some;
    return some;
  }
  /// The vertices of all meshes that do not rest, and the first of all, which is in each step's bookkeeping.
  std::vector<VertexRange> acting() const {
    std::vector<VertexRange> ranges;
    for (const MeshConstants& c : meshes_.all())
      if (c.rests == 0) ranges.push_back({c.first_vertex, c.first_vertex + c.vertex_count});
    if (ranges.empty() || ranges[0].first > 0) ranges.insert(ranges.begin(), {0, 1});
    return ranges;
  }
  bool acts(std::size_t k) const {
    const MeshNeeds needs = forces_.needs_of_mesh(k, meshes_[k]);
    return std::any_of(force_list().begin(), force_list().end(),
                       [&](const ForceInfo& force) { return needs.acts(force.id); });
  }
  bool needs_levels() const { return supervision_.corrected() && meshes_.vertex_count() > 0; }
  /// Some step is one of a few vertices for which nothing is found anew, and nothing summed.
  bool needs_tiles(const StepNeeds& needs) const {
    if (!Executor::kTiles || meshes_.vertex_count() > kMostInTiles) return false;
    int acting = 0;
    for (std::size_t k = 0; k < meshes_.size(); ++k) acting += acts(k) ? meshes_[k].vertex_count : 0;
    return acting > 0 && acting <= kMostTiledVertices && !needs_levels() &&
           !(needs.searches() && refresh_interval() == 1) && (needs.forces & kBuiltForces & kPullingForces) == 0;
  }
  void drop_what_is_not_needed() {
    forces_.drop(needs_, kBuiltForces & needs_.forces);
    supervision_.drop();
    if (!needs_levels() || !levels_.held()) levels_.drop();
    if (!needs_tiles(needs_) || !tiles_.held()) tiles_.drop(), meshes_.hold_one_frame(phase_.frame);
  }
};

}  // namespace simplexseg
