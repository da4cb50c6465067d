// SPDX-License-Identifier: Apache-2.0
// Error against run time, for `simplexseg-cli study error-time`.
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

/// Solver with its settings.
struct Method {
  std::string name;
  int solver;  ///< index in the choices of the parameter `solver`
  SimulationParameters simulation;
  bool baseline = false;  ///< baseline of the ratios: Verlet, damping 0.1, 95% of its limit
};
/// Methods to compare: every solver with the settings of the scene, and Verlet with several settings.
std::vector<Method> methods_for(const FrozenProblem& problem);

/// Error after a number of steps, relative to the initial error.
struct FrozenSample {
  std::int64_t steps;
  double seconds;        ///< time of the steps alone
  double whole, normal;  ///< distance to the fixed point, and its component along the normals there
};
struct FrozenCurve {
  Method method;
  std::vector<FrozenSample> samples;
  int cuts = 0;      ///< number of steps that were undone and repeated with a smaller timestep
  std::string note;  ///< description of a problem; empty: none
};
/// Seconds that the first step spends on binding attraction points to vertices; 0 without points. They are the same for
/// every method and are subtracted from its time.
double binding_seconds(const FrozenProblem& problem, const EngineFactory& make_engine);
/// Runs a method from the start until the error is below 1e-4 of the initial error, stalls, or `budget_s` is spent on
/// steps. Poses are read between steps, untimed; the times of the first half second are medians of three further runs
/// without reading, ten steps at a time as in a session. `binding_s` is subtracted.
FrozenCurve run_frozen(const FrozenProblem& problem, const Method& method, double budget_s, double binding_s,
                       const EngineFactory& make_engine, const Poll& poll);

/// First sample from which on the error stays at or below a share of the initial error.
struct Reached {
  std::int64_t steps;
  double seconds;
};
std::optional<Reached> reached(const std::vector<FrozenSample>& samples, double share, bool normal_part);

/// Settings of a complete run of a scene from its seeds.
struct LiveVariant {
  int solver;
  int refresh_interval;
  bool coarse_to_fine;  ///< false: meshes start with their final number of vertices
};
/// All combinations of solver, refresh interval (1, 3 or 10 steps) and start.
std::vector<LiveVariant> live_variants();
struct LiveSample {
  std::int64_t steps;
  double seconds;  ///< time of the simulation alone
  int vertices;    ///< vertices of this mesh
  SurfaceError::Values error;
  double dice;  ///< Dice in the bounding box of the reference, enlarged by half on each side
};
struct LiveCurve {
  LiveVariant variant;
  std::vector<std::vector<LiveSample>> meshes;  ///< samples of each mesh; none for a mesh without a reference
  bool at_rest = false;
  std::string note;
};

/// Runs of one scene, which share its references. `study` must outlive this object.
class LiveStudy {
 public:
  explicit LiveStudy(const StudyScene& study);
  /// True if some mesh has a reference mask.
  bool has_truth() const;
  /// Runs until the scene settles, for its number of steps (2000 if it has none), or until `budget_s` is spent.
  LiveCurve run(const LiveVariant& variant, double budget_s, const EngineFactory& make_engine, const Poll& poll) const;

 private:
  struct Truth {
    SurfaceError surface;
    Mask cropped;  ///< the mask in the surroundings of the object
  };
  const StudyScene& study_;
  std::vector<std::optional<Truth>> truths_;
};

}  // namespace simplexseg
