// SPDX-License-Identifier: Apache-2.0
// The engine: what a step is, once, for every executor (gpu/launcher.h).
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
      bind(volume_);  // which may have been given up for the other
      throw;
    }
    volume_ = volume;
    phase_.refresh_due = true;
  }

  void load(std::span<const EngineMesh> meshes, const SimulationParameters& simulation,
            std::span<const EnginePoint> points) override {
    for (const EngineMesh& m : meshes) check_field(m.field, volume_);
    Loaded before;  // once exchanged
    exchange(before);
    try {
      meshes_.load(meshes);
      forces_.load(meshes, meshes_);
      forces_.set_points(points, meshes_);
      results_.load(meshes_);
      std::vector<SolverState> learnt;
      for (const EngineMesh& m : meshes) wanted_.push_back(m.parameters), learnt.push_back(m.solver);
      apply_parameters(simulation, learnt);
    } catch (...) {
      exchange(before);
      runs_.clear();
      update_view();
      throw;
    }
    drawing_.forget_cells();
    runs_.clear();
  }

  void set_parameters(std::span<const ForceParameters> meshes, const SimulationParameters& simulation,
                      std::span<const char> finest) override {
    SIMPLEXSEG_EXPECT(meshes.size() == meshes_.size() && (finest.empty() || finest.size() == meshes_.size()));
    all_or_nothing([&](Undo&) {
      wanted_.assign(meshes.begin(), meshes.end());
      for (std::size_t k = 0; k < finest.size(); ++k) meshes_[k].finest = finest[k];
      apply_parameters(simulation, {});
    });
  }

  void set_points(std::span<const EnginePoint> points) override {
    all_or_nothing([&](Undo& undo) {
      undo = forces_.set_points(points, meshes_);
      meshes_.note_limits(volume_, forces_.points());
      for (std::size_t k = 0; k < meshes_.size(); ++k) supervision_.control(k).set_points(meshes_[k].point_count);
      if (meshes_.size() != 0) meshes_.send_constants();
      if (supervision_.forms_changed(meshes_))
        apply_forms();
      else
        hold_what_is_needed();
      phase_.refresh_due = true;
    });
  }

  void set_field(int mesh, const EngineField& field) override {
    check_field(field, volume_);
    all_or_nothing([&](Undo& undo) {
      const bool had = forces_.has_field(mesh);
      undo = forces_.set_field(mesh, field, meshes_);
      if (forces_.has_field(mesh) != had) return apply_parameters(simulation_, {});
      meshes_.send_constants();
      hold_what_is_needed();
      phase_.refresh_due = true;
    });
  }

  void refresh() override { phase_.refresh_due = true; }

  void give_targets(int mesh, ForceId force, std::span<const Vec4> targets) override {
    all_or_nothing([&](Undo& undo) {
      undo = forces_.give_targets(mesh, force, targets, meshes_);
      apply_parameters(simulation_, {});  // now the force acts
    });
  }
  void read_targets(int mesh, ForceId force, std::span<Vec4> targets) override {
    forces_.read_targets(mesh, force, targets, meshes_);
  }

  StepOutcome step(int count) override {
    StepOutcome outcome;
    if (meshes_.vertex_count() == 0 || count <= 0) {
      outcome.steps = std::max(count, 0);
      for (std::size_t k = 0; k < meshes_.size(); ++k) measure(k, MeshMotion{}, 0, outcome);
      return outcome;
    }
    [[maybe_unused]] const auto range = executor().range("steps");
    if (forms_due_) apply_forms();
    while (outcome.steps < count && !outcome.failure && !forms_due_) {
      const int batch = supervision_.batch(count - outcome.steps, meshes_);
      const bool interval_ends = supervision_.ends_interval(batch);
      update_view();
      supervision_.keep_poses(launcher_, view_, meshes_);
      const int done = run_batch(batch, interval_ends ? End::Interval : End::Batch);
      executor().wait();
      if (const auto failed = results_.failure()) {
        undo_failed_step(*failed, done, outcome);
      } else {
        outcome.steps += done;
        const bool support_due = supervision_.support_is_due();
        supervision_.note_batch(done, meshes_, results_.motion());
        if (support_due) note_support();
        if (interval_ends) learn(outcome);
        if (this->leave_out_what_rests(launcher_)) runs_.clear();
      }
    }
    for (std::size_t k = 0; k < meshes_.size(); ++k) measure(k, results_.motion()[k], residual_mm(k), outcome);
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
  bool has_cells() const override { return drawing_.knows_cells(); }

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

  std::vector<HeldArray> held_arrays() const override {
    std::vector<HeldArray> held;
    auto add = [&](const char* name, const auto&... arrays) {
      if (const std::size_t bytes = (arrays.bytes() + ...); bytes != 0) held.push_back({name, bytes});
    };
    if (!volume_.empty()) held.push_back({"volume", volume_.bytes()});
    meshes_.list(add), forces_.list(add), supervision_.list(add), levels_.list(add), drawing_.list(add);
    results_.list(add), this->tiles_.list(add);
    return held;
  }
  std::size_t bytes_available() const override {
    const std::size_t free = executor().bytes_free();
    return free > std::numeric_limits<std::size_t>::max() - bytes_held() ? free : free + bytes_held();
  }
  std::size_t bytes_held() const override {
    std::size_t sum = 0;
    for (const HeldArray& a : held_arrays()) sum += a.bytes;
    return sum;
  }
  std::vector<KernelCount> kernel_counts() const override {
    std::vector<KernelCount> counts;
    for (const auto& [name, n] : launcher_.launches) counts.push_back({std::string(name), n});
    return counts;
  }

 private:
  using Loaded = LoadedMeshes<Executor>;
  using Undo = typename ForceArrays<Executor>::Undo;
  using Loaded::active, Loaded::refresh_interval, Loaded::residual_mm, Loaded::measure;
  using Loaded::meshes_, Loaded::forces_, Loaded::supervision_, Loaded::levels_, Loaded::results_, Loaded::tiles_;
  using Loaded::wanted_, Loaded::simulation_, Loaded::needs_, Loaded::phase_, Loaded::forms_due_;
  void exchange(Loaded& other) { std::swap(static_cast<Loaded&>(*this), other); }
  Executor& executor() { return launcher_.executor; }
  const Executor& executor() const { return launcher_.executor; }
  template <class Kernel>
  void run(const Kernel& over_all_vertices) {
    launcher_.run_over_vertices(over_all_vertices, meshes_.vertex_count());
  }

  /// Up to `count` steps, of which `end` is the end. Returns how many were done before a failure that the host knows
  /// of.
  int run_batch(int count, End end) {
    int done = 0;
    while (done < count) {
      const int length = length_of_run(count - done);
      supervision_.send_coefficients();
      const int ran = run_steps(length, done + length < count ? End::None : end);
      done += ran;
      if (ran < length) {
        end_batch();
        break;
      }
    }
    return done;
  }
  /// `length` steps, and the end of the batch when something ends. Returns how many were done before a failure that the
  /// host knows of.
  int run_steps(int length, End end) {
    return runs_.run(launcher_, phase_, refresh_interval(), length, end, [&] { return do_steps(length, end); });
  }
  int do_steps(int length, End end) {
    for (int k = 0; k < length; ++k)
      if (!do_step({k, length}, k + 1 == length ? end : End::None)) return k;
    if (end != End::None) end_batch();
    return length;
  }

  /// False when the step failed and the host knows.
  bool do_step(OfRun of_run, End end) {
    update_view();
    const bool refresh = phase_.refresh_due || phase_.since_refresh >= refresh_interval();
    if (refresh) phase_.since_refresh = 0, phase_.refresh_due = false;
    ++phase_.since_refresh;
    if (end != End::None) phase_.measured_at_refresh = refresh;
    tiles_.held() && !(refresh && needs_.searches()) ? step_by_tiles(of_run, end)
                                                     : step_by_kernels(of_run, end, refresh);
    if (executor().failed(results_.status())) return false;
    phase_.oldest = (phase_.oldest + 1) % 3;
    return true;
  }
  void step_by_kernels(OfRun of_run, End end, bool refresh) {
    const bool attract = active(AttractionForce::id);
    const GeometryKernel geometry{view_, of_run, attract && refresh};
    const int n = meshes_.vertex_count();
    if (!attract)
      run(geometry);
    else if (refresh)
      launcher_.run_together(geometry, n, FindNearest{view_},
                             view_.mesh_count * view_.attraction.nearest_blocks * view_.attraction.groups);
    else
      launcher_.run_together(geometry, n, SumAttraction{view_}, view_.attraction.count);
    if (Executor::kSumsRings && active(SmoothingForce::id)) run(SumRings{view_});
    if (refresh) find_targets(attract);
    if (levels_.held()) {
      if (refresh || phase_.stiffness_due) find_stiffness();
      phase_.stiffness_due = false;
      integrate(of_run, end);
      levels_.cycle(launcher_, view_);
      run(CorrectedStep{view_, of_run, end});
    } else {
      integrate(of_run, end);
    }
  }
  void step_by_tiles(OfRun of_run, End end) {
    if constexpr (Executor::kTiles) {
      StepView view = view_;
      view.new_frame = meshes_.other_frame(phase_.frame);
      run_for<kBuiltForces & ~kPullingForces>(needs_.forces, [&]<unsigned kMask>() {
        launcher_.run_tiles(TileStep<kMask>{view, tiles_.view(), of_run, end});
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

  /// Changes settings of the meshes that are loaded; when that throws, all are put back, and by `undo` what the change
  /// has said there.
  void all_or_nothing(const std::function<void(Undo& undo)>& change) {
    auto before = this->settings();
    Undo undo;
    try {
      change(undo);
    } catch (...) {
      if (undo) undo();
      this->put_back(std::move(before));
      update_view();
      throw;
    }
  }

  /// `learnt`: what the solver of each mesh has learnt earlier; empty where it is to begin anew.
  void apply_parameters(const SimulationParameters& simulation, std::span<const SolverState> learnt) {
    simulation_ = simulation;
    supervision_.set_simulation(simulation, meshes_.size());
    bool internal = false;
    for (std::size_t k = 0; k < meshes_.size(); ++k) {
      MeshConstants& c = meshes_[k];
      c.forces = wanted_[k];
      const float voxel_mm = volume_.empty() ? 1.0f : static_cast<float>(volume_.geometry().spacing_mm.minCoeff());
      const Stiffness stiffness = tell_forces(c, forces_.needs_of_mesh(k, c), forces_.shape_of(k, c), voxel_mm);
      internal = internal || stiffness.internal > 0;
      SolverControl& control = supervision_.control(k);
      control.start(simulation, stiffness, learnt.empty() ? SolverState{} : learnt[k], Executor::kCycleCost);
      control.set_points(c.point_count);
    }
    const bool cycles = simulation.solver() == Solver::Automatic || simulation.solver() == Solver::Multigrid;
    if (cycles && internal) levels_.arrange(meshes_.all(), meshes_.neighbours());
    meshes_.note_limits(volume_, forces_.points());
    apply_forms();
    phase_.refresh_due = true;
  }

  /// After a solver has changed how it steps.
  void apply_forms() {
    supervision_.tell_forms(meshes_);
    phase_.stiffness_due = true;
    forms_due_ = true;
    hold_what_is_needed();
    forms_due_ = false;
    for (std::size_t k = 0; k < meshes_.size(); ++k) meshes_[k].root = levels_.root(k);
    meshes_.send_constants();
    update_view();
  }

  /// The same after a batch, whose steps stand: what does not fit is asked for again, and said, before the next one.
  void apply_learnt_forms() {
    try {
      apply_forms();
    } catch (const std::exception&) {
      SIMPLEXSEG_ENSURE(forms_due_);
    }
  }

  /// At the end of an interval.
  void learn(StepOutcome& outcome) {
    supervision_.end_interval(meshes_, results_.motion(), phase_.measured_at_refresh, refresh_interval());
    for (std::size_t k = 0; k < meshes_.size() && !outcome.failure; ++k) {
      const auto failure = supervision_.judge(k, meshes_, results_.motion()[k], residual_mm(k),
                                              phase_.measured_at_refresh, refresh_interval());
      if (failure) undo(*failure, outcome);
    }
    if (supervision_.forms_changed(meshes_))
      apply_learnt_forms();
    else if (supervision_.corrected())
      note_support();
  }
  void note_support() {
    const bool anew = supervision_.note_support(meshes_, results_.motion());
    if (supervision_.forms_changed(meshes_)) return apply_learnt_forms();
    if (anew) meshes_.send_constants(), phase_.stiffness_due = true;
  }

  /// `done`: steps of the batch that were begun, of which one failed.
  void undo_failed_step(const typename BatchResults<Executor>::Failure& failed, int done, StepOutcome& outcome) {
    // Steps after the failed one were skipped, so the two poses before it are untouched.
    phase_.oldest = ((phase_.oldest - (done - failed.step)) % 3 + 3) % 3;
    outcome.steps += failed.step + 1;
    const int mesh = meshes_.mesh_of(failed.vertex);
    undo({mesh, meshes_.orders()[mesh][failed.vertex - meshes_[mesh].first_vertex], failed.force}, outcome);
  }
  /// Puts the mesh back to the pose that was kept, or to the last good one, at rest, and halves its timestep.
  void undo(const StepFailure& failure, StepOutcome& outcome) {
    const MeshConstants& c = meshes_[failure.mesh];
    Vec4* now = meshes_.positions_at(phase_.oldest + 1);
    launcher_.run(RestorePose{supervision_.good_poses(now), now, meshes_.positions_at(phase_.oldest), c.first_vertex},
                  c.vertex_count);
    executor().wait();
    forces_.forget_pulls();
    phase_.refresh_due = true;
    if (supervision_.cut(failure.mesh))
      outcome.cuts.push_back({failure, supervision_.control(failure.mesh).cut_factor()});
    else
      outcome.failure = failure;
  }

  void find_stiffness() {
    run_for<kBuiltForces & ~kInternalForces>(needs_.forces & ~kInternalForces,  // which are in the model as a whole
                                             [&]<unsigned kMask>() { run(LocalStiffness<kMask>{view_}); });
    levels_.sum_stiffness(launcher_, view_);
  }

  void hold_what_is_needed() {
    const StepView view_before = view_;
    const StepNeeds needed_before = needs_;
    const bool tiles_before = tiles_.held();
    if (this->wake(launcher_)) runs_.clear();
    this->hold_arrays(!volume_.empty());
    update_view();
    const int interval_before = std::exchange(recorded_interval_, refresh_interval());
    // Recorded runs hold the addresses and the plan.
    if (!(needed_before == needs_) || tiles_before != tiles_.held() || interval_before != recorded_interval_ ||
        !same_addresses(view_before, view_))
      runs_.clear();
  }

  void update_view() {
    meshes_.show(view_, phase_.oldest, phase_.frame);
    forces_.show(view_, needs_);
    view_.coefficients = supervision_.coefficients();
    view_.levels = levels_.view();
    view_.status = results_.status();
  }

  /// `bind`: attraction patches too, beside the first search.
  void find_targets(bool bind) {
    TargetSearches<Executor>(launcher_, view_, needs_, forces_.averaging(), bind).search_all(volume_.type());
  }

  /// Runs the kernel that was compiled for exactly the forces in use.
  void integrate(OfRun of_run, End end) {
    run_for<kBuiltForces>(needs_.forces, [&]<unsigned kMask>() {
      if (levels_.held())
        run(IntegrateKernel<kMask, true>{view_, of_run, end});
      else
        run(IntegrateKernel<kMask, false>{view_, of_run, end});
    });
  }

  Launcher<Executor> launcher_;
  Volume volume_;
  StepView view_;
  int recorded_interval_ = 0;  ///< the refresh interval that recorded runs have in them
  SurfaceDrawing<Executor> drawing_;
  RecordedRuns<Executor> runs_;
};

}  // namespace simplexseg
