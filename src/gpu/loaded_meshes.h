// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
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

/// Data of the loaded meshes in an engine. load() builds a new object; if that fails, it restores the previous one.
template <class Executor>
class LoadedMeshes {
 protected:
  static constexpr bool built(ForceId force) { return (kBuiltForces & bit(force)) != 0; }

  bool active(ForceId force) const { return built(force) && needs_.uses(force); }
  int refresh_interval() const { return static_cast<int>(simulation_.refresh_interval + 0.5f); }

  using Undo = typename ForceArrays<Executor>::Undo;
  /// Copy of the state that a change of settings modifies, except for the arrays and their host data.
  struct Settings {
    std::vector<ForceParameters> requested;
    SimulationParameters simulation;
    StepNeeds needs;
    StepPhase phase;
    bool forms_due;
    std::vector<MeshConstants> constants;
    typename StepSupervision<Executor>::Settings supervision;
  };
  Settings settings() const {
    return {requested_,
            simulation_,
            needs_,
            phase_,
            forms_due_,
            {meshes_.all().begin(), meshes_.all().end()},
            supervision_.settings()};
  }
  void restore(Settings before) {
    requested_ = std::move(before.requested), simulation_ = before.simulation, needs_ = before.needs;
    phase_ = before.phase, forms_due_ = before.forms_due;
    meshes_.restore(std::move(before.constants));
    supervision_.restore(std::move(before.supervision));
    release_unneeded();
    if (meshes_.size() != 0) meshes_.upload_constants();
  }

  /// Changes settings of the loaded meshes. If `change` throws, restores the previous settings and calls `undo`, if
  /// `change` has set it, to restore the host data of the forces.
  void all_or_nothing(const std::function<void(Undo& undo)>& change) {
    Settings before = settings();
    Undo undo;
    try {
      change(undo);
    } catch (...) {
      if (undo) undo();
      restore(std::move(before));
      throw;
    }
  }

  /// Allocates the arrays that the step needs, then releases the others. After a failed allocation the existing arrays
  /// are unchanged; new ones may remain until restore().
  void allocate_needed_arrays(bool has_volume) {
    std::vector<MeshNeeds> meshes;
    for (std::size_t k = 0; k < meshes_.size(); ++k) meshes.push_back(forces_.needs_of_mesh(k, meshes_[k]));
    const StepNeeds needs = needs_of(meshes, simulation_, has_volume, forces_.point_count());
    if (needs_levels()) levels_.allocate(meshes_.all(), meshes_.neighbours());
    if (needs_tiles(needs)) tiles_.allocate(meshes_.neighbours()), meshes_.allocate_second_frame(phase_.frame);
    if (needs.areas) meshes_.allocate_areas();
    supervision_.allocate(meshes_);
    forces_.allocate(needs, kBuiltForces & needs.forces, meshes_);
    needs_ = needs;
    release_unneeded();
  }

  /// Excludes sleeping meshes from later steps, and includes all others. `asleep`: one value per mesh. Meshes that fall
  /// asleep get velocity 0. True if the excluded meshes have changed; recorded runs are then invalid.
  bool set_asleep(std::span<const char> asleep, Launcher<Executor>& launcher, const StepView& view) {
    bool changed = false, falls_asleep = false;
    for (std::size_t k = 0; k < meshes_.size(); ++k) {
      MeshConstants& c = meshes_[k];
      if ((c.asleep != 0) == (asleep[k] != 0)) continue;
      changed = true;
      c.asleep = asleep[k] != 0;
      if (c.asleep == 0) continue;
      falls_asleep = true;
      for (const int other : {0, 2})
        launcher.run(StopMesh{view.current, meshes_.positions_at(phase_.oldest + other), c.first_vertex},
                     c.vertex_count);
      launcher.run(StopMesh{view.current, meshes_.positions_at(phase_.oldest + 1), c.first_vertex}, c.vertex_count);
    }
    if (!changed) return false;
    launcher.executor.restrict_vertices({});
    if (falls_asleep) {
      launcher.run_over_vertices(GeometryKernel{view, {1, 1}}, meshes_.vertex_count());
      meshes_.copy_frames(launcher, phase_.frame);
    }
    meshes_.upload_constants();
    launcher.executor.restrict_vertices(awake_vertices());
    phase_.refresh_due = true;
    return true;
  }

  /// Loads meshes and points. Arrays that are the same in `before` are shared. `spacing_mm`: of the volume.
  void load_arrays(std::span<const EngineMesh> meshes, std::span<const EnginePoint> points,
                   const Eigen::Vector3d& spacing_mm, const LoadedMeshes& before) {
    meshes_.load(meshes, before.meshes_);
    forces_.load(meshes, spacing_mm, meshes_, before.forces_);
    forces_.set_points(points, meshes_);
    results_.load(meshes_);
  }
  /// Measures the loaded poses if a mesh is loaded asleep, then excludes the sleeping meshes from the steps.
  void load_asleep(std::span<const EngineMesh> meshes, Launcher<Executor>& launcher, const StepView& view) {
    std::vector<char> asleep;
    for (const EngineMesh& m : meshes) asleep.push_back(m.asleep);
    if (std::find(asleep.begin(), asleep.end(), 1) == asleep.end()) return;
    launcher.run_over_vertices(GeometryKernel{view, {0, 1}}, meshes_.vertex_count());
    results_.end_batch(launcher, view);
    launcher.executor.wait();
    set_asleep(asleep, launcher, view);
  }

  /// Vertices of all meshes that are awake, and always vertex 0, whose kernel call updates the step counters; no
  /// ranges if all are.
  std::vector<VertexRange> awake_vertices() const {
    std::vector<VertexRange> ranges;
    for (const MeshConstants& c : meshes_.all())
      if (c.asleep == 0) ranges.push_back({c.first_vertex, c.first_vertex + c.vertex_count});
    if (ranges.size() == meshes_.size()) return {};
    if (ranges.empty() || ranges[0].first > 0) ranges.insert(ranges.begin(), {0, 1});
    return ranges;
  }
  bool all_asleep() const {
    return std::all_of(meshes_.all().begin(), meshes_.all().end(),
                       [](const MeshConstants& c) { return c.asleep != 0; });
  }
  /// Residual of mesh k in the last step of a batch, mm: root mean square of the force over the vertices, divided by
  /// the sum of the weights of the active forces.
  float residual_mm(std::size_t k) {
    float weights = 0;
    for (const ForceInfo& force : force_list()) weights += active(force.id) ? meshes_[k].forces.weight(force.id) : 0.0f;
    return weights > 0 ? std::sqrt(std::max(results_.motion()[k].mean_square_force, 0.0f)) / weights : 0.0f;
  }
  /// Appends the measurements of mesh k to the outcome.
  void add_outcome(std::size_t k, const MeshMotion& motion, float residual_mm, StepOutcome& outcome) const {
    outcome.mean_move_mm.push_back(motion.mean_move_mm);
    outcome.mean_edge_mm.push_back(motion.mean_edge_mm);
    outcome.residual_mm.push_back(residual_mm);
    outcome.folded_vertices.push_back(static_cast<int>(motion.folded));
    outcome.inverted.push_back(motion.volume < 0);
    outcome.solver.push_back(supervision_.control(k).state());
  }

  /// Parameters of each mesh as set; in MeshConstants, inactive forces have weight 0.
  std::vector<ForceParameters> requested_;
  SimulationParameters simulation_{};
  StepNeeds needs_;
  StepPhase phase_;
  bool forms_due_ = false;  ///< true while new step forms are pending: their arrays could not be allocated
  MeshArrays<Executor> meshes_;
  ForceArrays<Executor> forces_;
  StepSupervision<Executor> supervision_;
  CoarseLevels<Executor> levels_;
  Tiles<Executor> tiles_;
  BatchResults<Executor> results_;

 private:
  bool acts(std::size_t k) const {
    const MeshNeeds needs = forces_.needs_of_mesh(k, meshes_[k]);
    return std::any_of(force_list().begin(), force_list().end(),
                       [&](const ForceInfo& force) { return needs.acts(force.id); });
  }
  bool needs_levels() const { return supervision_.corrected() && meshes_.vertex_count() > 0; }
  /// True if some steps can use tiles: few active vertices, no multigrid cycle, no areas, no attraction, and no
  /// search for targets in every step.
  bool needs_tiles(const StepNeeds& needs) const {
    if (!Executor::kTiles || meshes_.vertex_count() > kMaxVerticesWithTiles) return false;
    int count = 0;
    for (std::size_t k = 0; k < meshes_.size(); ++k) count += acts(k) ? meshes_[k].vertex_count : 0;
    return count > 0 && count <= kMaxTiledVertices && !needs_levels() && !needs.areas &&
           !(needs.searches() && refresh_interval() == 1) && (needs.forces & kBuiltForces & kPullingForces) == 0;
  }
  void release_unneeded() {
    forces_.release_unneeded(needs_, kBuiltForces & needs_.forces);
    supervision_.release_unneeded();
    if (!needs_.areas) meshes_.release_areas();
    if (!needs_levels() || !levels_.allocated()) levels_.release();
    if (!needs_tiles(needs_) || !tiles_.allocated()) tiles_.release(), meshes_.release_second_frame(phase_.frame);
  }
};

}  // namespace simplexseg
