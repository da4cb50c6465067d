// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "gpu/fold_monitor.h"
#include "gpu/kernels.h"
#include "gpu/launcher.h"
#include "gpu/mesh_arrays.h"
#include "step/solver.h"

namespace simplexseg {

/// Chooses the step form of each mesh, updates the solvers from measurements of the steps, and detects steps to undo.
/// The engine executes these decisions.
template <class Executor>
class StepSupervision {
  template <class T>
  using Array = typename Executor::template Array<T>;
  using Meshes = MeshArrays<Executor>;

 public:
  /// State that a change of settings modifies, for its restoration after a failure.
  struct Settings {
    std::vector<SolverControl> controls;
    int interval_steps = 0;                   ///< number of steps since the interval began
    int interval = SolverControl::kInterval;  ///< number of steps in the interval
    bool evaluates_intervals = false;
    bool saves_pose = false, corrected = false, regularisation_known = false;
  };
  Settings settings() const { return s_; }
  void restore(Settings settings) { s_ = std::move(settings), uploaded_.clear(); }

  /// Applies settings; the caller must then call SolverControl::start() for each mesh.
  void set_simulation(const SimulationParameters& simulation, std::size_t meshes) {
    s_.controls.resize(meshes);
    s_.interval_steps = 0, s_.interval = SolverControl::kInterval;
    s_.saves_pose = simulation.can_diverge();
    s_.evaluates_intervals = s_.saves_pose || simulation.solver() == Solver::Damped;
  }
  SolverControl& control(std::size_t k) { return s_.controls[k]; }
  const SolverControl& control(std::size_t k) const { return s_.controls[k]; }

  /// True if some mesh used multigrid cycles at the last call of set_step_forms().
  bool corrected() const { return s_.corrected; }
  bool forms_changed(const Meshes& meshes) const {
    for (std::size_t k = 0; k < meshes.size(); ++k)
      if (s_.controls[k].form() != meshes[k].form) return true;
    return false;
  }
  /// Copies the step forms of the solvers to the meshes.
  void set_step_forms(Meshes& meshes) {
    s_.corrected = false;
    for (const SolverControl& control : s_.controls)
      s_.corrected = s_.corrected || control.form() == StepForm::Corrected;
    for (std::size_t k = 0; k < meshes.size(); ++k) {
      const float regularisation = s_.controls[k].state().regularisation;
      meshes[k].form = s_.controls[k].form();
      meshes[k].regularisation = regularisation > 0 ? regularisation : SolverControl::kStrongRegularisation;
      s_.regularisation_known =
          (k == 0 || s_.regularisation_known) && (regularisation > 0 || meshes[k].form != StepForm::Corrected);
    }
    uploaded_.clear();
  }
  /// Allocates the arrays that are needed.
  void allocate(const Meshes& meshes) {
    const std::size_t n = meshes.vertex_count();
    if (s_.saves_pose && saved_pose_.size() != n) saved_pose_.resize(n), saved_pose_.fill_zero();
    if (coefficients_.size() != meshes.size()) coefficients_.resize(meshes.size()), uploaded_.clear();
  }
  /// Releases the arrays that are not needed.
  void release_unneeded() {
    if (!s_.saves_pose) saved_pose_.resize(0);
  }
  const StepCoefficients* coefficients() { return coefficients_.data(); }
  void upload_coefficients() {
    std::vector<StepCoefficients> now;
    for (const SolverControl& control : s_.controls) now.push_back(control.coefficients());
    if (now == uploaded_) return;
    coefficients_.upload(now);
    uploaded_ = std::move(now);
  }

  // Steps run in batches. A batch never extends beyond the end of an interval, where the solvers are updated.

  /// Number of steps of the next batch, at most `max_steps`.
  int batch(int max_steps, const Meshes& meshes) {
    first_fold_measurement_ = saved_pose_.size() != 0 && !folds_.initialised(meshes.size());
    // A first batch of one step measures the regularisation and the folds of the initial pose.
    const bool first = (s_.corrected && !s_.regularisation_known) || first_fold_measurement_;
    if (first) return std::min(max_steps, 1);
    return s_.evaluates_intervals ? std::min(max_steps, s_.interval - s_.interval_steps) : max_steps;
  }
  bool ends_interval(int batch) const { return s_.evaluates_intervals && s_.interval_steps + batch == s_.interval; }
  /// Saves the poses if an interval begins, because the interval may have to be undone.
  void save_poses(Launcher<Executor>& launcher, const StepView& view, Meshes& meshes) {
    constexpr int kSaved = 2;  // value of MeshConstants::asleep after the pose was saved
    if (saved_pose_.size() == 0 || s_.interval_steps != 0) return;
    for (std::size_t k = 0; k < meshes.size(); ++k) {
      if (meshes[k].asleep == kSaved) continue;
      if (folds_.accept_pose(k))
        launcher.run(SavePose{view.current, saved_pose_.data(), meshes[k].first_vertex}, meshes[k].vertex_count);
      if (meshes[k].asleep != 0) meshes[k].asleep = kSaved;
    }
  }
  /// Adds the steps of a successful batch to the interval.
  void advance_interval(int steps, const Meshes& meshes, const MeshMotion* motion) {
    s_.interval_steps = s_.evaluates_intervals ? (s_.interval_steps + steps) % s_.interval : 0;
    if (first_fold_measurement_) folds_.initialise(meshes.all(), motion);
  }
  bool regularisation_is_due() const { return s_.corrected && !s_.regularisation_known; }
  /// Determines from the measurements whether image and attraction forces constrain each mesh with multigrid cycles.
  /// True if the regularisation of a mesh has changed.
  bool update_regularisation(Meshes& meshes, const MeshMotion* motion) {
    bool changed = false;
    for (std::size_t k = 0; k < meshes.size(); ++k) {
      MeshConstants& c = meshes[k];
      if (c.form != StepForm::Corrected) continue;
      s_.controls[k].set_constrained(motion[k].external_stiffness > kMinExternalStiffness * c.model);
      changed = changed || s_.controls[k].state().regularisation != c.regularisation;
      c.regularisation = s_.controls[k].state().regularisation;
    }
    s_.regularisation_known = true;
    return changed;
  }

  /// Ends an interval; must be called before reason_to_undo(), with the same last two arguments. If the last step of
  /// every later interval would be a refresh, too, the next interval is one step longer, because motion at a refresh
  /// contains no information about the stiffness.
  void end_interval(const Meshes& meshes, const MeshMotion* motion, bool measured_at_refresh, int refresh_interval) {
    folds_.update(meshes.all(), motion);
    const bool recurs = refresh_interval > 1 && SolverControl::kInterval % refresh_interval == 0;
    s_.interval = SolverControl::kInterval + (measured_at_refresh && recurs ? 1 : 0);
  }
  /// Updates the solver of mesh k after an interval and returns the reason to undo the interval, if any. `residual_mm`:
  /// as in StepOutcome; `measured_at_refresh`: whether the measured step was a refresh; `refresh_interval`: steps.
  std::optional<StepFailure> reason_to_undo(std::size_t k, const Meshes& meshes, const MeshMotion& motion,
                                            float residual_mm, bool measured_at_refresh, int refresh_interval) {
    const MeshConstants& c = meshes[k];
    const auto failure = [&](StepFailure::Kind kind) {
      return StepFailure{static_cast<int>(k), -1, static_cast<ForceId>(c.strongest), kind};
    };
    if (saved_pose_.size() != 0 && folds_.folded_by_steps(k, residual_mm, motion, c.edge_mm))
      return failure(StepFailure::Kind::Folded);
    // Motion caused by new targets contains no information about the stiffness, unless every step is a refresh.
    if (measured_at_refresh && refresh_interval > 1) return std::nullopt;
    // Motion below the floating-point precision of a position, or far below an edge length, is rounding noise.
    const float farthest = static_cast<float>(meshes.start_distance_mm(k)) + motion.mean_edge_mm;
    const float noise = std::max(1e-4f * motion.mean_edge_mm, 1e-6f * farthest);
    if (s_.controls[k].update(motion.change, motion.square_move, noise) && !measured_at_refresh)
      return failure(StepFailure::Kind::Diverged);
    return std::nullopt;
  }
  /// Poses to restore: the saved poses, or `last` if poses are not saved.
  const Vec4* poses_to_restore(const Vec4* last) { return saved_pose_.size() != 0 ? saved_pose_.data() : last; }
  /// Halves the timestep of mesh k after its pose was restored, and begins a new interval. False as
  /// SolverControl::cut().
  bool cut(std::size_t k) {
    s_.interval_steps = 0;
    s_.evaluates_intervals = true;
    folds_.restore(static_cast<int>(k));
    return s_.controls[k].cut();
  }

  /// Calls add(name, arrays...) for each group of arrays.
  template <class Add>
  void list_arrays(Add&& add) const {
    add("step coefficients", coefficients_), add("kept pose", saved_pose_);
  }

 private:
  /// External stiffness, as a share of k of the multigrid model, above which a mesh counts as constrained.
  static constexpr float kMinExternalStiffness = 1e-3f;

  Settings s_;
  FoldMonitor folds_;
  std::vector<StepCoefficients> uploaded_;
  Array<StepCoefficients> coefficients_;
  Array<Vec4> saved_pose_;
  bool first_fold_measurement_ = false;
};

}  // namespace simplexseg
