// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "forces/step_form.h"
#include "step/simulation_parameters.h"
#include "step/stability.h"

namespace simplexseg {

/// What a solver has learnt of a mesh; 0: nothing yet.
struct SolverState {
  float slowest = 0;       ///< estimated smallest eigenvalue of -dz/dx
  bool multigrid = false;  ///< automatic: the correction has been found worth it
  float support = 0;  ///< of the multigrid model (MeshConstants::support): SolverControl::kSupportFree or kSupportFirm
};

/// Chooses the steps of one mesh. The largest eigenvalue is known before the first step from the bounds that forces
/// report. The smallest one is estimated as the run goes on, as the Rayleigh quotient of the last move (P. Underwood,
/// Dynamic Relaxation, in: Computational Methods for Transient Analysis, 1983): what still moves is what is slow.
class SolverControl {
 public:
  /// Steps between two estimates, counted from start(); once one more where targets are found anew in the last of them.
  static constexpr int kInterval = 10;
  /// What supports every vertex in the multigrid model besides its forces, as shares of the model's k. What nothing
  /// supports drifts by what its forces do not balance, and a cycle would make that a leap: such a mesh is supported
  /// all over (free), as all are in the first step, until its forces are seen to do it (firm).
  static constexpr float kSupportFree = 10, kSupportFirm = 1e-5f;

  /// New forces or settings: the timestep is no longer cut, and what was learnt is forgotten unless `state` has it.
  /// `cycle_cost`: of a step with a multigrid cycle, in steps without.
  void start(const SimulationParameters& simulation, const Stiffness& stiffness, const SolverState& state = {},
             float cycle_cost = 1);

  StepForm form() const;
  /// How many attraction points the mesh has. Where points alone support it, what lies between them is slow.
  void set_points(int count);
  /// What a step with a cycle showed: whether image and points support the mesh in all directions. What few points
  /// hardly support drifts by what its forces do not balance: there `automatic` takes no cycles.
  void set_supported(bool supported);
  StepCoefficients coefficients() const;

  /// What the steps of an interval showed: `change` and `square_move` as of MeshMotion; a root mean square move below
  /// `noise_mm` says nothing. True when they were unstable: the interval is to be undone.
  bool learn(float change, float square_move, float noise_mm);
  /// Halves the timestep. False when it has been cut too often: something else is wrong.
  bool cut();
  float cut_factor() const { return cut_; }  ///< of the timestep
  const SolverState& state() const { return state_; }
  const Stiffness& stiffness() const { return stiffness_; }

 private:
  float fastest() const;
  float first_guess() const;
  void correct_where_worth();
  void take_no_cycles();

  Solver solver_ = Solver::Verlet;
  Stiffness stiffness_;
  StepCoefficients fixed_{0, 0};
  SolverState state_;
  int points_ = 0;
  bool looked_ = false;  ///< set_supported() was called since start()
  float cut_ = 1, cycle_cost_ = 1;
};

}  // namespace simplexseg
