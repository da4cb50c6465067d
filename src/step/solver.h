// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "forces/step_form.h"
#include "step/simulation_parameters.h"
#include "step/stability.h"

namespace simplexseg {

/// Estimates of the solver of one mesh; a number of 0 means no estimate yet.
struct SolverState {
  float min_eigenvalue = 0;  ///< estimated smallest eigenvalue of -dz/dx; z: update of a vertex (StepForm)
  bool multigrid = false;    ///< true if solver `automatic` uses multigrid cycles
  float regularisation = 0;  ///< MeshConstants::regularisation: kStrongRegularisation or kWeakRegularisation
};

/// Chooses gain and momentum of the steps of one mesh. The bounds of the forces limit the largest eigenvalue of -dz/dx
/// before the first step. The smallest eigenvalue is estimated during the run as the Rayleigh quotient of a move, which
/// slow modes dominate (P. Underwood, Dynamic Relaxation, in: Computational Methods for Transient Analysis, 1983).
class SolverControl {
 public:
  /// Number of steps in an interval, at whose end the estimates are updated. If an interval ended with an update of the
  /// targets, and all later ones would too, the next interval is one step longer.
  static constexpr int kInterval = 10;
  /// Diagonal regularisation of the multigrid model, in addition to the stiffness of the forces, as a share of k of the
  /// model (src/gpu/multigrid.h). Weak if image and attraction forces constrain the mesh in all directions; strong
  /// otherwise and in the first step, because a cycle would turn the drift of an unconstrained mesh into a jump.
  static constexpr float kStrongRegularisation = 10, kWeakRegularisation = 1e-5f;

  /// Starts with new forces or settings: resets the reduction of the timestep and sets the estimates to `state`.
  /// `stiffness`: bounds of the active forces; `cycle_cost`: duration of a step with a multigrid cycle, relative to a
  /// step without.
  void start(const SimulationParameters& simulation, const Stiffness& stiffness, const SolverState& state = {},
             float cycle_cost = 1);

  StepForm form() const;
  /// Sets the number of attraction points of the mesh. If only points constrain the mesh, its modes between the points
  /// are slow, and `automatic` uses cycles.
  void set_points(int count);
  /// Sets whether image and attraction forces constrain the mesh in all directions, as measured in a step with a cycle.
  /// For an unconstrained mesh, which drifts, `automatic` uses no cycles unless an image force is active.
  void set_constrained(bool constrained);
  StepCoefficients coefficients() const;

  /// Updates the estimates after an interval; returns true if its steps were unstable and must be undone. `change` and
  /// `square_move`: as in MeshMotion, mm^2. No update if the root mean square of the move is at most `noise_mm`.
  bool update(float change, float square_move, float noise_mm);
  /// Halves the timestep. Returns false after more than 12 halvings; the failure then has another cause.
  bool cut();
  float cut_factor() const { return cut_; }  ///< product of all halvings of the timestep since start()
  const SolverState& state() const { return state_; }
  const Stiffness& stiffness() const { return stiffness_; }

 private:
  float max_eigenvalue() const;
  float initial_estimate() const;
  void enable_cycles_if_faster();
  void disable_cycles();

  Solver solver_ = Solver::Verlet;
  Stiffness stiffness_;
  StepCoefficients fixed_{0, 0};
  SolverState state_;
  int points_ = 0;
  bool constraint_known_ = false;  ///< true if set_constrained() was called after start()
  float cut_ = 1, cycle_cost_ = 1;
};

}  // namespace simplexseg
