// SPDX-License-Identifier: Apache-2.0
#include "step/solver.h"

#include <algorithm>
#include <cmath>

#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

// Upper bounds of the eigenvalues of -dz/dx, including a margin. For forces that are divided by their bound the largest
// eigenvalue is at most 1; with a multigrid cycle the largest measured value is 2.4 (spheres of 20 to 330,000
// vertices).
constexpr float kMaxEigenvalueScaled = 1.1f, kMaxEigenvalueCorrected = 2.6f;
constexpr float kMinEigenvalueEstimate = 1e-6f;  // lower limit of the estimates
// Lower limits of the eigenvalue from which the damping is computed; the estimate may be smaller.
constexpr float kMinEigenvalueScaled = 3e-4f, kMinEigenvalueUnconstrained = 0.02f, kMinEigenvalueCorrected = 0.05f;
/// Square root of the condition number of -dz/dx with a multigrid cycle. The number of steps to a given error is
/// proportional to this root.
constexpr float kCorrectedRoot = 2.2f;
constexpr float kMinCut = 1.0f / 4096;

}  // namespace

void SolverControl::start(const SimulationParameters& simulation, const Stiffness& stiffness, const SolverState& state,
                          float cycle_cost) {
  solver_ = simulation.solver();
  stiffness_ = stiffness;
  state_ = state;
  cut_ = 1, cycle_cost_ = cycle_cost;
  points_ = 0, constraint_known_ = false;
  const float dt = effective_timestep(simulation, stiffness.total());
  fixed_ = {dt * dt, 1.0f - simulation.damping};
  if (!(state_.min_eigenvalue > 0)) state_.min_eigenvalue = initial_estimate();
  enable_cycles_if_faster();
}

StepForm SolverControl::form() const {
  switch (solver_) {
    case Solver::Verlet:
      return StepForm::Plain;
    case Solver::Multigrid:
      return stiffness_.internal > 0 ? StepForm::Corrected : StepForm::Scaled;
    case Solver::Automatic:
      return state_.multigrid && stiffness_.internal > 0 ? StepForm::Corrected : StepForm::Scaled;
    default:
      return StepForm::Scaled;
  }
}

void SolverControl::set_points(int count) {
  // A change of the points requires a new measurement of the constraints.
  if (count != points_ && constraint_known_ && solver_ == Solver::Automatic &&
      state_.regularisation >= kStrongRegularisation)
    state_.regularisation = 0;
  points_ = count;
  if (count == 0 && constraint_known_) disable_cycles();
  enable_cycles_if_faster();
}

void SolverControl::set_constrained(bool constrained) {
  constraint_known_ = true;
  state_.regularisation = constrained ? kWeakRegularisation : kStrongRegularisation;
  if (!constrained) disable_cycles();
}

void SolverControl::disable_cycles() {
  if (!state_.multigrid || stiffness_.image > 0) return;  // an image force may constrain the mesh later
  state_.multigrid = false;
  state_.min_eigenvalue = initial_estimate();
}

void SolverControl::enable_cycles_if_faster() {
  if (solver_ != Solver::Automatic || state_.multigrid || !(stiffness_.internal > 0)) return;
  if (!(stiffness_.image > 0) && (points_ == 0 || state_.regularisation >= kStrongRegularisation)) return;
  if (stiffness_.image > 0 && std::sqrt(max_eigenvalue() / state_.min_eigenvalue) <= kCorrectedRoot * cycle_cost_)
    return;
  state_.multigrid = true;
  state_.min_eigenvalue = initial_estimate();
}

float SolverControl::max_eigenvalue() const {
  return form() == StepForm::Corrected ? kMaxEigenvalueCorrected : kMaxEigenvalueScaled;
}

float SolverControl::initial_estimate() const {
  if (form() == StepForm::Corrected) return 0.3f;
  // The estimate assumes that image forces or points act on every vertex.
  const float external = stiffness_.image > 0 ? stiffness_.image : stiffness_.external;
  return external > 0 ? std::max(external / (stiffness_.internal + external), kMinEigenvalueUnconstrained)
                      : kMinEigenvalueUnconstrained;
}

StepCoefficients SolverControl::coefficients() const {
  if (form() == StepForm::Plain) return {fixed_.gain * cut_ * cut_, fixed_.momentum};
  // Without an image force, some modes may be unconstrained; with little damping they would drift.
  float min_eigenvalue = stiffness_.image > 0 ? kMinEigenvalueScaled : kMinEigenvalueUnconstrained;
  if (form() == StepForm::Corrected) min_eigenvalue = kMinEigenvalueCorrected;
  const float a = max_eigenvalue(), b = std::clamp(state_.min_eigenvalue, min_eigenvalue, a);
  if (form() == StepForm::Scaled && !(stiffness_.image > 0)) {
    // A mesh attracted only by points must not overshoot them, so the gain is 1, and the damping is optimal for it.
    const float root = 1 - std::sqrt(std::min(b, 1.0f));
    return {cut_ * cut_, root * root};
  }
  const float s = std::sqrt(a), t = std::sqrt(b);
  return {4 / ((s + t) * (s + t)) * cut_ * cut_, (s - t) * (s - t) / ((s + t) * (s + t))};
}

bool SolverControl::update(float change, float square_move, float noise_mm) {
  if (!std::isfinite(change) || !std::isfinite(square_move) || !(square_move > noise_mm * noise_mm)) return false;
  const float quotient = change / square_move;
  // Scaled steps are always stable and need no check. In other steps a growing mode dominates the quotient, which then
  // approximates the eigenvalue for which the timestep is too large.
  const StepCoefficients c = coefficients();
  if (form() != StepForm::Scaled && quotient * c.gain > 2 * (1 + c.momentum)) return true;
  if (form() == StepForm::Plain || !(quotient > 0)) return false;
  // The estimate decreases at once, by a factor of at most 8, because too much damping hides slow modes. It increases
  // only to the geometric mean, because fast modes may not have decayed yet.
  float& min_eigenvalue = state_.min_eigenvalue;
  min_eigenvalue =
      quotient < min_eigenvalue ? std::max(quotient, min_eigenvalue / 8) : std::sqrt(min_eigenvalue * quotient);
  min_eigenvalue = std::clamp(min_eigenvalue, kMinEigenvalueEstimate, 0.5f * max_eigenvalue());
  enable_cycles_if_faster();
  return false;
}

bool SolverControl::cut() {
  cut_ *= 0.5f;
  return cut_ >= kMinCut;
}

}  // namespace simplexseg
