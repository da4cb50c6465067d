// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "gpu/fold_watch.h"
#include "gpu/kernels.h"
#include "gpu/launcher.h"
#include "gpu/mesh_arrays.h"
#include "step/solver.h"

namespace simplexseg {

/// Decides how each mesh steps, learns from what the steps showed, and says which steps must not stand. The engine
/// carries that out.
template <class Executor>
class StepSupervision {
  template <class T>
  using Array = typename Executor::template Array<T>;
  using Meshes = MeshArrays<Executor>;

 public:
  /// What set_simulation() and tell_forms() change.
  struct Settings {
    std::vector<SolverControl> controls;
    int since_watched = 0, interval = SolverControl::kInterval;  ///< steps
    bool watched = false;                                        ///< every interval of steps is looked at
    bool keeps_pose = false, corrected = false, support_known = false;
  };
  Settings settings() const { return s_; }
  void put_back(Settings settings) { s_ = std::move(settings), sent_.clear(); }

  /// Other settings; start() follows for each mesh.
  void set_simulation(const SimulationParameters& simulation, std::size_t meshes) {
    s_.controls.resize(meshes);
    s_.since_watched = 0, s_.interval = SolverControl::kInterval;
    s_.keeps_pose = simulation.may_grow();
    s_.watched = s_.keeps_pose || simulation.solver() == Solver::Damped;
  }
  SolverControl& control(std::size_t k) { return s_.controls[k]; }
  const SolverControl& control(std::size_t k) const { return s_.controls[k]; }

  /// Some mesh takes multigrid cycles.
  bool corrected() const { return s_.corrected; }
  bool forms_changed(const Meshes& meshes) const {
    for (std::size_t k = 0; k < meshes.size(); ++k)
      if (s_.controls[k].form() != meshes[k].form) return true;
    return false;
  }
  /// Tells the meshes how they step now.
  void tell_forms(Meshes& meshes) {
    s_.corrected = false;
    for (const SolverControl& control : s_.controls)
      s_.corrected = s_.corrected || control.form() == StepForm::Corrected;
    for (std::size_t k = 0; k < meshes.size(); ++k) {
      const float support = s_.controls[k].state().support;
      meshes[k].form = s_.controls[k].form();
      meshes[k].support = support > 0 ? support : SolverControl::kSupportFree;
      s_.support_known = (k == 0 || s_.support_known) && (support > 0 || meshes[k].form != StepForm::Corrected);
    }
    sent_.clear();
  }
  /// Makes the arrays that are needed and not held.
  void make(const Meshes& meshes) {
    const std::size_t n = meshes.vertex_count();
    if (s_.keeps_pose && kept_.size() != n) kept_.resize(n), kept_.fill_zero();
    if (coefficients_.size() != meshes.size()) coefficients_.resize(meshes.size()), sent_.clear();
  }
  /// Gives back what is not needed.
  void drop() {
    if (!s_.keeps_pose) kept_.resize(0);
  }
  const StepCoefficients* coefficients() { return coefficients_.data(); }
  void send_coefficients() {
    std::vector<StepCoefficients> now;
    for (const SolverControl& control : s_.controls) now.push_back(control.coefficients());
    if (now == sent_) return;
    coefficients_.upload(now);
    sent_ = std::move(now);
  }

  // A batch of steps: to the end of the interval after which the solvers look at what they did, or all of it.

  /// How many of `most` steps belong to the next batch.
  int batch(int most, const Meshes& meshes) {
    begins_folds_ = kept_.size() != 0 && !folds_.knows(meshes.size());
    // What is not known before a first step: what supports the meshes, and which of them are folded.
    const bool first = (s_.corrected && !s_.support_known) || begins_folds_;
    if (first) return std::min(most, 1);
    return s_.watched ? std::min(most, s_.interval - s_.since_watched) : most;
  }
  bool ends_interval(int batch) const { return s_.watched && s_.since_watched + batch == s_.interval; }
  /// Before an interval that may have to be undone.
  void keep_poses(Launcher<Executor>& launcher, const StepView& view, Meshes& meshes) {
    constexpr int kKept = 2;  // of MeshConstants::rests: the pose that is kept is that of its rest
    if (kept_.size() == 0 || s_.since_watched != 0) return;
    for (std::size_t k = 0; k < meshes.size(); ++k) {
      if (meshes[k].rests == kKept) continue;
      if (folds_.keeps(k))
        launcher.run(KeepPose{view.current, kept_.data(), meshes[k].first_vertex}, meshes[k].vertex_count);
      if (meshes[k].rests != 0) meshes[k].rests = kKept;
    }
  }
  /// After a batch that did not fail.
  void note_batch(int steps, const Meshes& meshes, const MeshMotion* motion) {
    s_.since_watched = s_.watched ? (s_.since_watched + steps) % s_.interval : 0;
    if (begins_folds_) folds_.begin(meshes.all(), motion);
  }
  bool support_is_due() const { return s_.corrected && !s_.support_known; }
  /// Whether forces support each mesh. True when a mesh has changed by it.
  bool note_support(Meshes& meshes, const MeshMotion* motion) {
    bool anew = false;
    for (std::size_t k = 0; k < meshes.size(); ++k) {
      MeshConstants& c = meshes[k];
      if (c.form != StepForm::Corrected) continue;
      s_.controls[k].set_supported(motion[k].support > kIsSupported * c.model);
      anew = anew || s_.controls[k].state().support != c.support;
      c.support = s_.controls[k].state().support;
    }
    s_.support_known = true;
    return anew;
  }

  /// Before each mesh is judged; the last two as there. Where targets were found anew in the last step, and would be in
  /// that of every interval from now on, the next is a step longer: nothing would ever be learnt else.
  void end_interval(const Meshes& meshes, const MeshMotion* motion, bool measured_at_refresh, int refresh_interval) {
    folds_.note(meshes.all(), motion);
    const bool again = refresh_interval > 1 && SolverControl::kInterval % refresh_interval == 0;
    s_.interval = SolverControl::kInterval + (measured_at_refresh && again ? 1 : 0);
  }
  /// What was wrong with the interval that mesh k has done, if it must be undone. `measured_at_refresh`: in a step that
  /// found targets anew; `residual_mm` as in StepOutcome.
  std::optional<StepFailure> judge(std::size_t k, const Meshes& meshes, const MeshMotion& motion, float residual_mm,
                                   bool measured_at_refresh, int refresh_interval) {
    const MeshConstants& c = meshes[k];
    const auto failure = [&](StepFailure::What what) {
      return StepFailure{static_cast<int>(k), -1, static_cast<ForceId>(c.strongest), what};
    };
    if (kept_.size() != 0 && folds_.crumpled(k, residual_mm, motion, c.edge_mm))
      return failure(StepFailure::What::Folded);
    // Targets that were found anew say nothing of stiffness, unless they always are.
    if (measured_at_refresh && refresh_interval > 1) return std::nullopt;
    // Below the digits of a position, and below what an edge is, motion is rounding.
    const float farthest = static_cast<float>(meshes.farthest_start(k)) + motion.mean_edge_mm;
    const float noise = std::max(1e-4f * motion.mean_edge_mm, 1e-6f * farthest);
    if (s_.controls[k].learn(motion.change, motion.square_move, noise) && !measured_at_refresh)
      return failure(StepFailure::What::Grew);
    return std::nullopt;
  }
  /// Where the mesh goes back to: what was kept, or `last` where nothing was.
  const Vec4* good_poses(const Vec4* last) { return kept_.size() != 0 ? kept_.data() : last; }
  /// The mesh was put back. False when a smaller timestep does not help.
  bool cut(std::size_t k) {
    s_.since_watched = 0;
    s_.watched = true;
    folds_.put_back(static_cast<int>(k));
    return s_.controls[k].cut();
  }

  /// add(name, arrays...) for each.
  template <class Add>
  void list(Add&& add) const {
    add("step coefficients", coefficients_), add("kept pose", kept_);
  }

 private:
  /// Forces support a mesh that have this share of the multigrid model's k.
  static constexpr float kIsSupported = 1e-3f;

  Settings s_;
  FoldWatch folds_;
  std::vector<StepCoefficients> sent_;
  Array<StepCoefficients> coefficients_;
  Array<Vec4> kept_;
  bool begins_folds_ = false;
};

}  // namespace simplexseg
