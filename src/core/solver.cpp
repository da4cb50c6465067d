// SPDX-License-Identifier: Apache-2.0
#include "core/solver.h"

#include <algorithm>
#include <cmath>

namespace simplexseg {
namespace {

// Bounds of the largest eigenvalue of -dz/dx with some room: 1 where forces are scaled by their own bound; for a multigrid
// cycle on spheres of 20 to 330,000 vertices at most 2.4 was measured.
constexpr float kFastestScaled = 1.1f, kFastestCorrected = 2.6f;
constexpr float kSlowestScaled = 1e-5f, kSlowestCorrected = 0.05f;
/// Steps to a given error go with the root of the ratio of the eigenvalues; with a cycle it is about this.
constexpr float kCorrectedRoot = 2.2f;
constexpr float kSmallestCut = 1.0f / 4096;

}  // namespace

void SolverControl::start(const SimulationParameters& simulation, const Stiffness& stiffness, const SolverState& state, float cycle_cost) {
  solver_ = simulation.solver();
  stiffness_ = stiffness;
  state_ = state;
  cut_ = 1, cycle_cost_ = cycle_cost;
  const float dt = solver_ == Solver::PointImplicit ? simulation.timestep : effective_timestep(simulation, stiffness.total());
  fixed_ = {dt * dt, 1.0f - simulation.damping};
  if (!(state_.slowest > 0)) state_.slowest = first_guess();
  if (solver_ == Solver::Automatic && worth_multigrid()) correct();
}

StepForm SolverControl::form() const {
  switch (solver_) {
    case Solver::Verlet: return StepForm::Plain;
    case Solver::PointImplicit: return StepForm::Implicit;
    case Solver::Multigrid: return StepForm::Corrected;
    case Solver::Automatic: return state_.multigrid ? StepForm::Corrected : StepForm::Scaled;
    default: return StepForm::Scaled;
  }
}

void SolverControl::correct() {
  if (solver_ != Solver::Automatic || state_.multigrid) return;
  state_.multigrid = true;
  state_.slowest = first_guess();
}

float SolverControl::fastest() const { return form() == StepForm::Corrected ? kFastestCorrected : kFastestScaled; }

float SolverControl::first_guess() const {
  if (form() == StepForm::Corrected) return 0.3f;
  // As if the image held every vertex.
  const float image = stiffness_.image;
  return image > 0 ? image / (stiffness_.internal + image) : 0.02f;
}

StepCoefficients SolverControl::coefficients(int since) const {
  if (form() == StepForm::Plain || form() == StepForm::Implicit) return {fixed_.gain * cut_ * cut_, fixed_.keep};
  const float a = fastest(), b = std::min(state_.slowest, a);
  if (solver_ == Solver::Chebyshev) {
    // Of the semi-iteration over [b, a]: with c = (a + b) / (a - b) the coefficients are ratios of Chebyshev polynomials
    // T_n(c), which grow as q^-n (G. Golub, R. Varga, Numerische Mathematik 3, 1961).
    const double c = (double(a) + b) / (double(a) - b), q = 1 / (c + std::sqrt(c * c - 1));
    const double n = since, omega = since == 0 ? 1 : 2 * c * q * (1 + std::pow(q, 2 * n)) / (1 + std::pow(q, 2 * n + 2));
    return {static_cast<float>(omega * 2 / (double(a) + b)) * cut_ * cut_, static_cast<float>(omega - 1)};
  }
  const float s = std::sqrt(a), t = std::sqrt(b);
  return {4 / ((s + t) * (s + t)) * cut_ * cut_, (s - t) * (s - t) / ((s + t) * (s + t))};
}

bool SolverControl::learn(float change, float square_move, float noise_mm) {
  if (!std::isfinite(change) || !std::isfinite(square_move) || !(square_move > noise_mm * noise_mm)) return false;
  const float quotient = change / square_move;
  if (form() != StepForm::Implicit) {
    // What grows takes the quotient over, and shows the eigenvalue that the timestep is too large for.
    const StepCoefficients c = coefficients(1 << 20);
    if (quotient * c.gain > 2 * (1 + c.keep)) return true;
  }
  if (form() == StepForm::Plain || form() == StepForm::Implicit || !(quotient > 0)) return false;
  // Downwards at once (the damping hides slow modes until it is right), upwards by half: fast modes are still on their way out.
  float& slowest = state_.slowest;
  slowest = quotient < slowest ? std::max(quotient, slowest / 8) : std::sqrt(slowest * quotient);
  const bool corrected = form() == StepForm::Corrected;
  slowest = std::clamp(slowest, corrected ? kSlowestCorrected : kSlowestScaled, 0.5f * fastest());
  if (solver_ == Solver::Automatic && worth_multigrid()) correct();
  return false;
}

bool SolverControl::worth_multigrid() const {
  return stiffness_.internal > 0 && std::sqrt(fastest() / state_.slowest) > kCorrectedRoot * cycle_cost_;
}

bool SolverControl::cut() {
  cut_ *= 0.5f;
  return cut_ >= kSmallestCut;
}

}  // namespace simplexseg
