// SPDX-License-Identifier: Apache-2.0
// The largest stable timestep of each force, measured by bisection, beside the bound that the force reports
// (docs/mathematics.md, section 3).
#pragma once
#include "study/stability_case.h"

namespace simplexseg {

/// One force near a fixed point of its own.
struct LimitProblem {
  std::string name;  ///< of the force, and what is special
  SimplexMesh mesh;  ///< a little off the fixed point
  std::vector<Vec4> shape;
  ForceParameters forces;
  std::vector<EnginePoint> points;
  std::optional<ForceId> given;  ///< the image force whose targets are these
  std::vector<Vec4> targets;
  std::function<double(const SimplexMesh&)> deviation;  ///< from the fixed point
};
std::vector<LimitProblem> limit_problems();
/// sqrt((4 - 2 damping) / stiffness) of the problem.
double predicted_limit(const LimitProblem& problem, double damping);

/// Whether the deviation grows (by 20 times within 600 steps, or a step is undone) at this timestep.
bool deviation_grows(const LimitProblem& problem, double damping, double timestep, const EngineFactory& make_engine);
/// Largest timestep at which it does not, within 0.5%; 0 when it grows at half of the predicted one, infinity when it
/// does not grow at a hundred times that.
double measured_limit(const LimitProblem& problem, double damping, const EngineFactory& make_engine);

struct StabilityLimit {
  std::string problem;
  double damping, predicted, measured;
  double difference() const { return measured / predicted - 1; }
  /// The stiffness that the measured limit stands for within 5% of the bound.
  bool as_predicted() const;
};
inline constexpr double kLimitDampings[] = {0.1, 0.3, 0.9};
/// Every problem with Verlet, which takes the timestep as it is given; other solvers choose their own steps.
std::vector<StabilityLimit> stability_limits(const EngineFactory& make_engine);

}  // namespace simplexseg
