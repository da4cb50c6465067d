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
  bool baseline = false;  ///< whether it is the baseline of the ratios: Verlet, damping 0.1, 95% of its limit
};
/// Methods to compare: Verlet with several settings, and every other solver with the settings of the scene.
std::vector<Method> methods_for(const FrozenProblem& problem);

/// Error after a number of steps, as a share of the initial error.
struct FrozenSample {
  std::int64_t steps;
  double seconds;        ///< time of the steps alone, without binding_seconds()
  double whole, normal;  ///< errors as in PoseError, each as a share of its initial value
};
struct FrozenCurve {
  Method method;
  std::vector<FrozenSample> samples;
  int cuts = 0;      ///< number of timestep reductions, each after steps were undone
  std::string note;  ///< description of a problem; empty: none
};
/// Time in seconds that the first step spends on binding attraction points to vertices, from the difference to the
/// second step; 0 without points. The time is the same for every method and is subtracted.
double binding_seconds(const FrozenProblem& problem, const EngineFactory& make_engine);
/// Runs a method from the start until both errors are below 1e-4 of the initial errors, decrease no further or diverge,
/// a step fails, or `budget_s` seconds are spent on steps. Poses are read between steps, untimed; the times of the
/// first half second are medians of three further runs without reading, ten steps at a time as in a session.
/// `binding_s`: result of binding_seconds(), which is subtracted.
FrozenCurve run_frozen(const FrozenProblem& problem, const Method& method, double budget_s, double binding_s,
                       const EngineFactory& make_engine, const Poll& poll);

/// First sample from which on the error remains at or below a share of the initial error. `normal_part`: whether the
/// error along the normals counts instead of the whole error.
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
  double seconds;  ///< time of the simulation alone, without sampling
  int vertices;    ///< number of vertices of this mesh
  SurfaceError::Values error;
  double dice;  ///< Dice coefficient in the bounding box of the reference, enlarged by half on each side
};
struct LiveCurve {
  LiveVariant variant;
  std::vector<std::vector<LiveSample>> meshes;  ///< samples of each mesh; none for a mesh without a reference
  bool at_rest = false;
  std::string note;
};

/// Runs of one scene with shared references. `study` must outlive this object.
class LiveStudy {
 public:
  explicit LiveStudy(const StudyScene& study);
  /// True if some mesh has a reference mask that is not empty.
  bool has_truth() const;
  /// Runs the scene from its seeds until all meshes settle, its number of steps (2000 if it has none) is reached, a
  /// step fails, or `budget_s` seconds are spent on steps.
  LiveCurve run(const LiveVariant& variant, double budget_s, const EngineFactory& make_engine, const Poll& poll) const;

 private:
  struct Truth {
    SurfaceError surface;
    Mask cropped;  ///< part of the mask around the object
  };
  const StudyScene& study_;
  std::vector<std::optional<Truth>> truths_;
};

}  // namespace simplexseg
