// SPDX-License-Identifier: Apache-2.0
// Largest stable timestep of each force, measured by bisection, for comparison with the bound of the force
// (docs/mathematics.md, section 3).
#pragma once
#include "study/stability_case.h"

namespace simplexseg {

/// Mesh under one force near a fixed point.
struct LimitProblem {
  std::string name;  ///< name of the force and its settings
  SimplexMesh mesh;  ///< pose with a small deviation from the fixed point
  std::vector<Vec4> shape;
  ForceParameters forces;
  std::vector<EnginePoint> points;
  std::optional<ForceId> target_force;  ///< image force to which `targets` belong
  std::vector<Vec4> targets;
  std::function<double(const SimplexMesh&)> deviation;  ///< measure of the deviation of a pose from the fixed point
};
std::vector<LimitProblem> limit_problems();
/// Predicted largest stable timestep of the problem: sqrt((4 - 2 damping) / stiffness).
double predicted_limit(const LimitProblem& problem, double damping);

/// True if the deviation grows at this timestep: by a factor of 20 within 600 steps, or so fast that the engine undoes
/// a step.
bool deviation_grows(const LimitProblem& problem, double damping, double timestep, const EngineFactory& make_engine);
/// Largest timestep at which the deviation does not grow, to 0.5%. 0 if it grows at half of the predicted limit;
/// infinite if it does not grow at a hundred times the predicted limit.
double measured_limit(const LimitProblem& problem, double damping, const EngineFactory& make_engine);

struct StabilityLimit {
  std::string problem;
  double damping, predicted, measured;
  double difference() const { return measured / predicted - 1; }
  /// True if the stiffness that follows from the measured limit is within 5% of the stiffness bound.
  bool as_predicted() const;
};
inline constexpr double kLimitDampings[] = {0.1, 0.3, 0.9};
/// Limits of all problems with Verlet, the only solver that uses the given timestep unchanged.
std::vector<StabilityLimit> stability_limits(const EngineFactory& make_engine);

}  // namespace simplexseg
