// SPDX-License-Identifier: Apache-2.0
// Error against run time: what simplexseg-cli study error-time measures.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "image/mask.h"
#include "image/surface_error.h"
#include "step/simulation_parameters.h"
#include "study/frozen_problem.h"
#include "study/study_scene.h"

namespace simplexseg {

/// One way to take steps.
struct Method {
  std::string name;
  int solver;  ///< its choice in the table of simulation parameters
  SimulationParameters simulation;
  bool baseline = false;  ///< what the others are compared with: Verlet, damping 0.1, 95% of its limit
};
/// Every solver of the table, with the settings worth comparing; the first is the scene's own setting.
std::vector<Method> methods_for(const FrozenProblem& problem);

/// Shares of the error with which the start began.
struct FrozenSample {
  std::int64_t steps;
  double seconds;        ///< of the steps alone
  double whole, normal;  ///< distance to the fixed point, and its part along the normals there
};
struct FrozenCurve {
  Method method;
  std::vector<FrozenSample> samples;
  int cuts = 0;      ///< steps that were undone and gone on with a smaller timestep
  std::string note;  ///< what went wrong; empty: nothing
};
/// What the first step spends on binding attraction points to vertices: the same for every method, and no part of it. 0
/// without points.
double binding_seconds(const FrozenProblem& problem, const EngineFactory& make_engine);
/// Steps from the start until the error is below 1e-4 of what it was, falls no more, or `budget_s` of steps are spent.
/// The poses are read between steps, off the clock; the times of the first half second are the medians of three further
/// runs without reading, ten steps at a time as in a session. `binding_s` is taken off.
FrozenCurve run_frozen(const FrozenProblem& problem, const Method& method, double budget_s, double binding_s,
                       const EngineFactory& make_engine, const Poll& poll);

/// When an error of so much is reached for good: the first sample from which on it is not exceeded.
struct Reached {
  std::int64_t steps;
  double seconds;
};
std::optional<Reached> reached(const std::vector<FrozenSample>& samples, double share, bool normal_part);

/// A whole run of a scene, from its seeds.
struct LiveVariant {
  int solver;
  int refresh_interval;
  bool coarse_to_fine;  ///< false: meshes start with the vertices that they end with
};
/// Every solver, refreshing targets every 1, 3 or 10 steps, and both ways to start.
std::vector<LiveVariant> live_variants();
struct LiveSample {
  std::int64_t steps;
  double seconds;  ///< of the simulation alone
  int vertices;    ///< of this mesh
  SurfaceError::Values error;
  double dice;  ///< within the reference's bounding box and half of it around
};
struct LiveCurve {
  LiveVariant variant;
  std::vector<std::vector<LiveSample>> meshes;  ///< samples of each mesh; none where it has no truth
  bool at_rest = false;
  std::string note;
};

/// Runs of one scene; what they share is made once. The truths must outlive it.
class LiveStudy {
 public:
  explicit LiveStudy(const StudyScene& study);
  /// Whether there is a truth to be compared with.
  bool measures() const;
  /// Until rest, the scene's steps (2000 where it has none), or `budget_s` of simulation.
  LiveCurve run(const LiveVariant& variant, double budget_s, const EngineFactory& make_engine, const Poll& poll) const;

 private:
  struct Truth {
    SurfaceError surface;
    Mask near;  ///< cut to what is around it
  };
  const StudyScene& study_;
  std::vector<std::optional<Truth>> truths_;
};

}  // namespace simplexseg
