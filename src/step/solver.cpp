// SPDX-License-Identifier: Apache-2.0
#include "step/solver.h"

#include <algorithm>
#include <cmath>

#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

// Bounds of the largest eigenvalue of -dz/dx with some room: 1 where forces are scaled by their own bound; for a
// multigrid cycle on spheres of 20 to 330,000 vertices at most 2.4 was measured.
constexpr float kFastestScaled = 1.1f, kFastestCorrected = 2.6f;
/// What damping is chosen for, at least; what is seen may be slower.
constexpr float kSlowestSeen = 1e-6f, kSlowestScaled = 3e-4f, kSlowestFree = 0.02f, kSlowestCorrected = 0.05f;
/// Steps to a given error go with the root of the ratio of the eigenvalues; with a cycle it is about this.
constexpr float kCorrectedRoot = 2.2f;
constexpr float kSmallestCut = 1.0f / 4096;

}  // namespace

void SolverControl::start(const SimulationParameters& simulation, const Stiffness& stiffness, const SolverState& state,
                          float cycle_cost) {
  solver_ = simulation.solver();
  stiffness_ = stiffness;
  state_ = state;
  cut_ = 1, cycle_cost_ = cycle_cost;
  points_ = 0, looked_ = false;
  const float dt = effective_timestep(simulation, stiffness.total());
  fixed_ = {dt * dt, 1.0f - simulation.damping};
  if (!(state_.slowest > 0)) state_.slowest = first_guess();
  correct_where_worth();
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
  // Other points are to be looked at again.
  if (count != points_ && looked_ && solver_ == Solver::Automatic && state_.support >= kSupportFree) state_.support = 0;
  points_ = count;
  if (count == 0 && looked_) take_no_cycles();
  correct_where_worth();
}

void SolverControl::set_supported(bool supported) {
  looked_ = true;
  state_.support = supported ? kSupportFirm : kSupportFree;
  if (!supported) take_no_cycles();
}

void SolverControl::take_no_cycles() {
  if (!state_.multigrid || stiffness_.image > 0) return;  // an image may support it later
  state_.multigrid = false;
  state_.slowest = first_guess();
}

void SolverControl::correct_where_worth() {
  if (solver_ != Solver::Automatic || state_.multigrid || !(stiffness_.internal > 0)) return;
  if (!(stiffness_.image > 0) && (points_ == 0 || state_.support >= kSupportFree)) return;
  if (stiffness_.image > 0 && std::sqrt(fastest() / state_.slowest) <= kCorrectedRoot * cycle_cost_) return;
  state_.multigrid = true;
  state_.slowest = first_guess();
}

float SolverControl::fastest() const { return form() == StepForm::Corrected ? kFastestCorrected : kFastestScaled; }

float SolverControl::first_guess() const {
  if (form() == StepForm::Corrected) return 0.3f;
  // As if image and points supported every vertex.
  const float support = stiffness_.image > 0 ? stiffness_.image : stiffness_.external;
  return support > 0 ? std::max(support / (stiffness_.internal + support), kSlowestFree) : kSlowestFree;
}

StepCoefficients SolverControl::coefficients() const {
  if (form() == StepForm::Plain) return {fixed_.gain * cut_ * cut_, fixed_.keep};
  // Where no image supports the mesh, what still moves may be supported by nothing: it would coast.
  float least = stiffness_.image > 0 ? kSlowestScaled : kSlowestFree;
  if (form() == StepForm::Corrected) least = kSlowestCorrected;
  const float a = fastest(), b = std::clamp(state_.slowest, least, a);
  if (form() == StepForm::Scaled && !(stiffness_.image > 0)) {
    // What points alone pull must not leap past them: the best damping for a gain of 1.
    const float rest = 1 - std::sqrt(std::min(b, 1.0f));
    return {cut_ * cut_, rest * rest};
  }
  const float s = std::sqrt(a), t = std::sqrt(b);
  return {4 / ((s + t) * (s + t)) * cut_ * cut_, (s - t) * (s - t) / ((s + t) * (s + t))};
}

bool SolverControl::learn(float change, float square_move, float noise_mm) {
  if (!std::isfinite(change) || !std::isfinite(square_move) || !(square_move > noise_mm * noise_mm)) return false;
  const float quotient = change / square_move;
  // No bound promises that steps do not grow but that of scaled ones. What grows takes the quotient over, and shows the
  // eigenvalue that the timestep is too large for.
  const StepCoefficients c = coefficients();
  if (form() != StepForm::Scaled && quotient * c.gain > 2 * (1 + c.keep)) return true;
  if (form() == StepForm::Plain || !(quotient > 0)) return false;
  // Downwards at once (the damping hides slow modes until it is right), upwards by half: fast modes are still on their
  // way out.
  float& slowest = state_.slowest;
  slowest = quotient < slowest ? std::max(quotient, slowest / 8) : std::sqrt(slowest * quotient);
  slowest = std::clamp(slowest, kSlowestSeen, 0.5f * fastest());
  correct_where_worth();
  return false;
}

bool SolverControl::cut() {
  cut_ *= 0.5f;
  return cut_ >= kSmallestCut;
}

}  // namespace simplexseg
