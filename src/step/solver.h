// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "forces/step_form.h"
#include "step/simulation_parameters.h"
#include "step/stability.h"

namespace simplexseg {

/// Estimates of a solver for one mesh; 0: no estimate yet.
struct SolverState {
  float min_eigenvalue = 0;  ///< estimated smallest eigenvalue of -dz/dx
  bool multigrid = false;    ///< solver automatic: multigrid cycles are faster
  float regularisation = 0;  ///< MeshConstants::regularisation: kStrongRegularisation or kWeakRegularisation
};

/// Chooses gain and damping of the steps of one mesh. The largest eigenvalue is bounded before the first step by the
/// forces' own bounds. The smallest one is estimated during the run as the Rayleigh quotient of the last move, which
/// the slow modes dominate (P. Underwood, Dynamic Relaxation, in: Computational Methods for Transient Analysis, 1983).
class SolverControl {
 public:
  /// Steps between two estimates, counted from start(). An interval is one step longer if the interval before it ended
  /// with an update of the targets, as all later ones would.
  static constexpr int kInterval = 10;
  /// Diagonal regularisation of the multigrid model, in addition to the stiffness of the forces, as a share of the
  /// model's k. Weak if image and attraction forces constrain the mesh in all directions. Strong otherwise and in the
  /// first step, because a cycle would turn the drift of an unconstrained mesh into a jump.
  static constexpr float kStrongRegularisation = 10, kWeakRegularisation = 1e-5f;

  /// Starts with new forces or settings: resets the cuts of the timestep and sets the estimates to `state`.
  /// `cycle_cost`: cost of a step with a multigrid cycle relative to one without.
  void start(const SimulationParameters& simulation, const Stiffness& stiffness, const SolverState& state = {},
             float cycle_cost = 1);

  StepForm form() const;
  /// Sets the number of attraction points of the mesh. If only points constrain it, the modes between them are slow.
  void set_points(int count);
  /// Sets whether image and attraction forces constrain the mesh in all directions, as measured in a step with a cycle.
  /// For an unconstrained mesh, which drifts, `automatic` uses no cycles.
  void set_constrained(bool constrained);
  StepCoefficients coefficients() const;

  /// Updates the estimates after an interval; returns true if its steps were unstable and must be undone. `change` and
  /// `square_move` as in MeshMotion; root mean square moves below `noise_mm` are ignored.
  bool update(float change, float square_move, float noise_mm);
  /// Halves the timestep. Returns false if it has been halved too often; the failure then has another cause.
  bool cut();
  float cut_factor() const { return cut_; }  ///< factor on the timestep
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
  bool constraint_known_ = false;  ///< set_constrained() was called after start()
  float cut_ = 1, cycle_cost_ = 1;
};

}  // namespace simplexseg
