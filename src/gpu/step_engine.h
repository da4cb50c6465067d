// SPDX-License-Identifier: Apache-2.0
// Engine for every executor (gpu/launcher.h): the sequence of kernels of a step.
#pragma once
#include <algorithm>
#include <functional>
#include <limits>
#include <type_traits>
#include <utility>

#include "core/error.h"
#include "forces/region_model.h"
#include "gpu/forces_in_use.h"
#include "gpu/kernels.h"
#include "gpu/loaded_meshes.h"
#include "gpu/mesh_settings.h"
#include "gpu/recorded_runs.h"
#include "gpu/surface_drawing.h"
#include "gpu/target_searches.h"
#include "gpu/volume_view.h"

namespace simplexseg {

template <class Executor>
class StepEngine final : public Engine, private LoadedMeshes<Executor> {
 public:
  explicit StepEngine(Executor executor) : launcher_{std::move(executor)} {}

  const char* backend() const override { return Executor::name; }
  std::string description() const override { return executor().description(); }

  void set_volume(const Volume& volume) override {
    runs_.clear();
    try {
      bind(volume);
    } catch (...) {
      bind(volume_);  // the failed call may have released it
      throw;
    }
    volume_ = volume;
    phase_.refresh_due = true;
  }

  void load(std::span<const EngineMesh> meshes, const SimulationParameters& simulation,
            std::span<const EnginePoint> points) override {
    for (const EngineMesh& m : meshes) check_field(m.field, volume_);
    Loaded before;  // the previous meshes, after exchange()
    exchange(before);
    executor().restrict_vertices({});
    try {
      this->load_arrays(meshes, points, volume_.geometry().spacing_mm, before);
      std::vector<SolverState> solver_states;
      for (const EngineMesh& m : meshes) requested_.push_back(m.parameters), solver_states.push_back(m.solver);
      apply_parameters(simulation, solver_states);
      update_view();
      this->load_asleep(meshes, launcher_, view_);
    } catch (...) {
      exchange(before);
      executor().restrict_vertices(this->awake_vertices());
      runs_.clear();
      update_view();
      throw;
    }
    drawing_.clear_cells();
    runs_.clear();
  }

  void set_parameters(std::span<const ForceParameters> meshes, const SimulationParameters& simulation,
                      std::span<const char> finest) override {
    SIMPLEXSEG_EXPECT(meshes.size() == meshes_.size() && (finest.empty() || finest.size() == meshes_.size()));
    all_or_nothing([&](Undo&) {
      requested_.assign(meshes.begin(), meshes.end());
      for (std::size_t k = 0; k < finest.size(); ++k) meshes_[k].finest = finest[k];
      apply_parameters(simulation, {});
    });
  }

  void set_points(std::span<const EnginePoint> points) override {
    all_or_nothing([&](Undo& undo) {
      undo = forces_.set_points(points, meshes_);
      meshes_.set_limits(volume_, forces_.points());
      for (std::size_t k = 0; k < meshes_.size(); ++k) supervision_.control(k).set_points(meshes_[k].point_count);
      if (meshes_.size() != 0) meshes_.upload_constants();
      if (supervision_.forms_changed(meshes_))
        apply_forms();
      else
        update_arrays();
      phase_.refresh_due = true;
    });
  }

  void set_asleep(std::span<const char> meshes) override {
    SIMPLEXSEG_EXPECT(meshes.size() == meshes_.size());
    update_view();
    if (Loaded::set_asleep(meshes, launcher_, view_)) runs_.clear();
  }

  void set_field(int mesh, const EngineField& field) override {
    check_field(field, volume_);
    all_or_nothing([&](Undo& undo) {
      const bool had = forces_.has_field(mesh);
      undo = forces_.set_field(mesh, field, volume_.geometry().spacing_mm, meshes_);
      if (forces_.has_field(mesh) != had) return apply_parameters(simulation_, {});
      update_arrays();
      meshes_.upload_constants();
      phase_.refresh_due = true;
    });
  }

  void refresh() override { phase_.refresh_due = true; }

  void set_fixed_targets(int mesh, ForceId force, std::span<const Vec4> targets) override {
    all_or_nothing([&](Undo& undo) {
      undo = forces_.set_fixed_targets(mesh, force, targets, meshes_);
      apply_parameters(simulation_, {});  // the force may become active
    });
  }
  void read_targets(int mesh, ForceId force, std::span<Vec4> targets) override {
    forces_.read_targets(mesh, force, targets, meshes_);
  }

  StepOutcome step(int count) override {
    StepOutcome outcome;
    if (this->all_asleep()) outcome.steps = std::max(count, 0);
    [[maybe_unused]] const auto range = executor().range("steps");
    if (forms_due_) apply_forms();
    while (outcome.steps < count && !outcome.failure && !forms_due_) {
      const int batch = supervision_.batch(count - outcome.steps, meshes_);
      const bool interval_ends = supervision_.ends_interval(batch);
      update_view();
      supervision_.save_poses(launcher_, view_, meshes_);
      const int done = run_batch(batch, interval_ends ? End::Interval : End::Batch);
      executor().wait();
      if (const auto failed = results_.failure()) {
        undo_failed_step(*failed, done, outcome);
      } else {
        outcome.steps += done;
        const bool regularisation_due = supervision_.regularisation_is_due();
        supervision_.advance_interval(done, meshes_, results_.motion());
        if (regularisation_due) update_regularisation();
        if (interval_ends) evaluate_interval(outcome);
      }
    }
    for (std::size_t k = 0; k < meshes_.size(); ++k) add_outcome(k, results_.motion()[k], residual_mm(k), outcome);
    return outcome;
  }

  void read(int mesh, std::span<Eigen::Vector3f> positions, std::span<Eigen::Vector3f> previous) override {
    meshes_.read(mesh, positions, previous, phase_.oldest);
  }

  std::unique_ptr<SharedBuffer> share_buffer(unsigned gl_buffer, std::size_t bytes) override {
    return executor().share_buffer(gl_buffer, bytes);
  }

  void set_cells(std::span<const CellList* const> cells) override {
    drawing_.set_cells(cells, meshes_.all(), meshes_.orders(), meshes_.vertex_count());
  }
  bool has_cells() const override { return drawing_.has_cells(); }

  void draw_surfaces(DrawTarget<DisplayPoint> target) override {
    [[maybe_unused]] const auto range = executor().range("draw surfaces");
    update_view();
    drawing_.draw_surfaces(launcher_, view_, target);
  }
  void draw_outlines(int axis, float position_mm, DrawTarget<std::byte> target) override {
    [[maybe_unused]] const auto range = executor().range("draw outlines");
    update_view();
    drawing_.draw_outlines(launcher_, view_, axis, position_mm, target);
  }
  void draw_slice(const SlicePlane& plane, DrawTarget<DisplayTexel> target) override {
    [[maybe_unused]] const auto range = executor().range("draw slice");
    if (!volume_.empty()) drawing_.draw_slice(launcher_, view_.volume, volume_.type(), plane, target);
  }
  std::uint64_t bytes_read_back() const override { return executor().bytes_read_back(); }

  std::vector<AllocatedArray> allocated_arrays() const override {
    std::vector<AllocatedArray> allocated;
    auto add = [&](const char* name, const auto&... arrays) {
      if (const std::size_t bytes = (arrays.bytes() + ...); bytes != 0) allocated.push_back({name, bytes});
    };
    if (!volume_.empty()) allocated.push_back({"volume", volume_.bytes()});
    meshes_.list_arrays(add), forces_.list_arrays(add), supervision_.list_arrays(add), levels_.list_arrays(add);
    drawing_.list_arrays(add), results_.list_arrays(add), this->tiles_.list_arrays(add);
    return allocated;
  }
  std::size_t bytes_available() const override {
    const std::size_t free = executor().bytes_free();
    return free > std::numeric_limits<std::size_t>::max() - bytes_allocated() ? free : free + bytes_allocated();
  }
  std::size_t bytes_allocated() const override {
    std::size_t sum = 0;
    for (const AllocatedArray& a : allocated_arrays()) sum += a.bytes;
    return sum;
  }
  std::vector<KernelCount> kernel_counts() const override {
    std::vector<KernelCount> counts;
    for (const auto& [name, n] : launcher_.launches) counts.push_back({std::string(name), n});
    return counts;
  }

 private:
  using Loaded = LoadedMeshes<Executor>;
  using Undo = typename Loaded::Undo;
  using Loaded::active, Loaded::refresh_interval, Loaded::residual_mm, Loaded::add_outcome, Loaded::all_or_nothing;
  using Loaded::meshes_, Loaded::forces_, Loaded::supervision_, Loaded::levels_, Loaded::results_, Loaded::tiles_;
  using Loaded::requested_, Loaded::simulation_, Loaded::needs_, Loaded::phase_, Loaded::forms_due_;
  void exchange(Loaded& other) { std::swap(static_cast<Loaded&>(*this), other); }
  Executor& executor() { return launcher_.executor; }
  const Executor& executor() const { return launcher_.executor; }
  template <class Kernel>
  void run(const Kernel& kernel) {
    launcher_.run_over_vertices(kernel, meshes_.vertex_count());
  }

  /// Runs up to `count` steps, the last of which ends the unit `end`. Returns the number of steps before a failure if
  /// the executor reports failures at once, else `count`.
  int run_batch(int count, End end) {
    int done = 0;
    while (done < count) {
      const int length = run_length(count - done);
      supervision_.upload_coefficients();
      const int ran = run_steps(length, done + length < count ? End::None : end);
      done += ran;
      if (ran < length) {
        end_batch();
        break;
      }
    }
    return done;
  }
  /// Runs `length` steps and, unless `end` is None, end_batch(). Returns a number of steps as run_batch() does.
  int run_steps(int length, End end) {
    return runs_.run(launcher_, phase_, refresh_interval(), length, end, [&] { return do_steps(length, end); });
  }
  int do_steps(int length, End end) {
    for (int k = 0; k < length; ++k)
      if (!do_step({k, length}, k + 1 == length ? end : End::None)) return k;
    if (end != End::None) end_batch();
    return length;
  }

  /// Runs one step. False if the step failed and the executor reports failures at once.
  bool do_step(StepInRun run_step, End end) {
    update_view();
    const bool refresh = phase_.refresh_due || phase_.since_refresh >= refresh_interval();
    if (refresh) phase_.since_refresh = 0, phase_.refresh_due = false;
    ++phase_.since_refresh;
    if (end != End::None) phase_.measured_at_refresh = refresh;
    tiles_.allocated() && !(refresh && needs_.searches()) ? step_by_tiles(run_step, end)
                                                          : step_by_kernels(run_step, end, refresh);
    if (executor().failed(results_.status())) return false;
    phase_.oldest = (phase_.oldest + 1) % 3;
    return true;
  }
  void step_by_kernels(StepInRun run_step, End end, bool refresh) {
    const bool attract = active(AttractionForce::id);
    const GeometryKernel geometry{view_, run_step, attract && refresh};
    const int n = meshes_.vertex_count();
    if (!attract)
      run(geometry);
    else if (refresh)
      launcher_.run_concurrently(geometry, n, FindNearest{view_},
                                 view_.mesh_count * view_.attraction.nearest_blocks * view_.attraction.groups);
    else
      launcher_.run_concurrently(geometry, n, SumAttraction{view_}, view_.attraction.count);
    if (Executor::kSumsRings && active(SmoothingForce::id)) run(SumRings{view_});
    if (needs_.areas) run(VertexMasses{view_});
    if (refresh) find_targets(attract);
    if (levels_.allocated()) {
      if (refresh || phase_.stiffness_due) find_stiffness();
      phase_.stiffness_due = false;
      integrate(run_step, end);
      levels_.cycle(launcher_, view_);
      run(CorrectedStep{view_, run_step, end});
    } else {
      integrate(run_step, end);
    }
  }
  void step_by_tiles(StepInRun run_step, End end) {
    if constexpr (Executor::kTiles) {
      StepView view = view_;
      view.new_frame = meshes_.other_frame(phase_.frame);
      run_for<kBuiltForces & ~kPullingForces>(needs_.forces, [&]<unsigned kMask>() {
        launcher_.run_tiles(TileStep<kMask>{view, tiles_.view(), run_step, end});
      });
      phase_.frame = 1 - phase_.frame;
    }
  }

  void end_batch() {
    update_view();
    results_.end_batch(launcher_, view_);
  }

  void bind(const Volume& volume) {
    executor().bind(volume, view_.volume);
    if (!volume.empty()) describe(volume, view_.volume);
  }

  /// Applies the parameters of all meshes. `solver_states`: earlier solver state of each mesh; empty: initial states.
  void apply_parameters(const SimulationParameters& simulation, std::span<const SolverState> solver_states) {
    simulation_ = simulation;
    supervision_.set_simulation(simulation, meshes_.size());
    bool internal = false;
    for (std::size_t k = 0; k < meshes_.size(); ++k) {
      MeshConstants& c = meshes_[k];
      c.forces = requested_[k];
      c.area_in_mass = simulation.area_in_mass, c.area_in_force = simulation.area_in_force;
      const float voxel_mm = volume_.empty() ? 1.0f : static_cast<float>(volume_.geometry().spacing_mm.minCoeff());
      const Stiffness stiffness = set_active_forces(c, forces_.needs_of_mesh(k, c), forces_.shape_of(k, c), voxel_mm);
      internal = internal || stiffness.internal > 0;
      SolverControl& control = supervision_.control(k);
      control.start(simulation, stiffness, solver_states.empty() ? SolverState{} : solver_states[k],
                    Executor::kCycleCost);
      control.set_points(c.point_count);
    }
    const bool cycles = simulation.solver() == Solver::Automatic || simulation.solver() == Solver::Multigrid;
    if (cycles && internal) levels_.arrange(meshes_.all(), meshes_.neighbours());
    meshes_.set_limits(volume_, forces_.points());
    apply_forms();
    phase_.refresh_due = true;
  }

  /// Applies the step forms that the solvers have chosen.
  void apply_forms() {
    supervision_.set_step_forms(meshes_);
    phase_.stiffness_due = true;
    forms_due_ = true;
    update_arrays();
    forms_due_ = false;
    for (std::size_t k = 0; k < meshes_.size(); ++k) meshes_[k].root = levels_.root(k);
    meshes_.upload_constants();
    update_view();
  }

  /// Applies the step forms after a batch, whose steps remain valid. After a failed allocation step() returns, and its
  /// next call retries the allocation, and throws if it fails again.
  void apply_forms_after_batch() {
    try {
      apply_forms();
    } catch (const std::exception&) {
      SIMPLEXSEG_ENSURE(forms_due_);
    }
  }

  /// Updates the solvers at the end of an interval, and undoes the interval for meshes whose steps failed.
  void evaluate_interval(StepOutcome& outcome) {
    supervision_.end_interval(meshes_, results_.motion(), phase_.measured_at_refresh, refresh_interval());
    for (std::size_t k = 0; k < meshes_.size() && !outcome.failure; ++k) {
      if (meshes_[k].asleep != 0) continue;
      const auto failure = supervision_.reason_to_undo(k, meshes_, results_.motion()[k], residual_mm(k),
                                                       phase_.measured_at_refresh, refresh_interval());
      if (failure) undo(*failure, outcome);
    }
    if (supervision_.forms_changed(meshes_))
      apply_forms_after_batch();
    else if (supervision_.corrected())
      update_regularisation();
  }
  void update_regularisation() {
    const bool changed = supervision_.update_regularisation(meshes_, results_.motion());
    if (supervision_.forms_changed(meshes_)) return apply_forms_after_batch();
    if (changed) meshes_.upload_constants(), phase_.stiffness_due = true;
  }

  /// Undoes a failed step. `done`: number of steps of the batch by which the phase has advanced.
  void undo_failed_step(const typename BatchResults<Executor>::Failure& failed, int done, StepOutcome& outcome) {
    // Steps after the failed one were skipped, so the two poses before it are unchanged.
    phase_.oldest = ((phase_.oldest - (done - failed.step)) % 3 + 3) % 3;
    outcome.steps += failed.step + 1;
    const int mesh = meshes_.mesh_of(failed.vertex);
    undo({mesh, meshes_.orders()[mesh][failed.vertex - meshes_[mesh].first_vertex], failed.force}, outcome);
  }
  /// Restores the saved pose of the mesh, or the last valid one, with velocity 0, and halves its timestep.
  void undo(const StepFailure& failure, StepOutcome& outcome) {
    const MeshConstants& c = meshes_[failure.mesh];
    Vec4* now = meshes_.positions_at(phase_.oldest + 1);
    launcher_.run(
        RestorePose{supervision_.poses_to_restore(now), now, meshes_.positions_at(phase_.oldest), c.first_vertex},
        c.vertex_count);
    executor().wait();
    forces_.clear_attraction();
    phase_.refresh_due = true;
    if (supervision_.cut(failure.mesh))
      outcome.cuts.push_back({failure, supervision_.control(failure.mesh).cut_factor()});
    else
      outcome.failure = failure;
  }

  void find_stiffness() {
    run_for<kBuiltForces & ~kInternalForces>(needs_.forces & ~kInternalForces,  // k L of the model includes these
                                             [&]<unsigned kMask>() { run(LocalStiffness<kMask>{view_}); });
    levels_.sum_stiffness(launcher_, view_);
  }

  void update_arrays() {
    const StepView view_before = view_;
    const StepNeeds needed_before = needs_;
    const bool tiles_before = tiles_.allocated();
    this->allocate_needed_arrays(!volume_.empty());
    if (tiles_before != tiles_.allocated()) meshes_.copy_frames(launcher_, phase_.frame);
    update_view();
    const int interval_before = std::exchange(recorded_interval_, refresh_interval());
    // Recorded runs contain the addresses of the arrays and the sequence of kernels.
    if (!(needed_before == needs_) || tiles_before != tiles_.allocated() || interval_before != recorded_interval_ ||
        !same_addresses(view_before, view_))
      runs_.clear();
  }

  void update_view() {
    meshes_.fill_view(view_, phase_.oldest, phase_.frame);
    forces_.fill_view(view_, needs_);
    view_.coefficients = supervision_.coefficients();
    view_.levels = levels_.view();
    view_.status = results_.status();
  }

  /// Runs the searches of a refresh. `bind`: whether to compute the attraction patches, with the first search.
  void find_targets(bool bind) {
    TargetSearches<Executor>(launcher_, view_, needs_, forces_.averaging(), bind).search_all(volume_.type());
  }

  void integrate(StepInRun run_step, End end) {
    run_for<kBuiltForces>(needs_.forces, [&]<unsigned kMask>() {
      if (levels_.allocated())
        run(IntegrateKernel<kMask, true>{view_, run_step, end});
      else
        run(IntegrateKernel<kMask, false>{view_, run_step, end});
    });
  }

  Launcher<Executor> launcher_;
  Volume volume_;
  StepView view_;
  int recorded_interval_ = 0;  ///< refresh interval of the recorded runs
  SurfaceDrawing<Executor> drawing_;
  RecordedRuns<Executor> runs_;
};

}  // namespace simplexseg
