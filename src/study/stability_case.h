// SPDX-License-Identifier: Apache-2.0
// Stability case: a stiff or extreme scene with its expected outcome. The observed outcome is measured independently of
// the program's own reports.
#pragma once
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "session/session.h"

namespace simplexseg {

using EngineFactory = std::function<std::unique_ptr<Engine>()>;

enum class CaseOutcome {
  Converges,  ///< the final error is within the case's tolerance
  Bounded,    ///< every final position is within the case's reach
  Cut,        ///< a step was undone, its timestep reduced, and a message given; the run finished within reach
  Pauses,     ///< the run stopped with a message that names mesh and force
  Refused,    ///< an Error with the reason prevented the run
  Fails,      ///< none of these, or an unreported fold or inversion of a mesh
};
const char* to_string(CaseOutcome outcome);

/// Scene and settings that a case runs, and the criteria for its outcome.
struct Trial {
  Scene scene;  ///< every mesh has a pose
  Volume volume;
  bool at_engine = false;  ///< runs the engine without a session, for values beyond the sliders' ranges
  int steps = 400;
  int chunk = 0;                               ///< number of steps between calls of `between`; 0: none
  std::function<void(Session&, int)> between;  ///< called with the number of finished chunks
  std::function<double(const Scene&)> error;   ///< error of the final scene; empty: the case has no target
  double tolerance = 0;                        ///< largest error that counts as converged
  double reach_mm = 60;                        ///< largest final distance of a vertex from the centre of the start
  bool folds = false;                          ///< folds may remain at the end; they must be reported
  bool inverted = false;                       ///< meshes may be inverted at the end; this must be reported
  bool cuts = false;                           ///< steps may be undone; this must be reported
};

struct StabilityCase {
  std::string name;                      ///< snake_case
  std::string what;                      ///< extreme property of the case
  CaseOutcome stated, stated_verlet;     ///< expected outcomes; only Verlet uses the given timestep unchanged
  std::string reason;                    ///< reason for the expected outcome
  std::function<Trial(bool full)> make;  ///< full: size of the study, otherwise size of the tests
  std::string refusal_text = {};         ///< expected part of the message of a refusal
};

/// All cases, in the order of the table.
std::span<const StabilityCase> stability_cases();

// The parts of the table.
std::vector<StabilityCase> force_cases();
std::vector<StabilityCase> setting_cases();
std::vector<StabilityCase> mesh_cases();
std::vector<StabilityCase> volume_cases();
std::vector<StabilityCase> point_cases();

/// Result of a case with one solver.
struct CaseResult {
  CaseOutcome outcome = CaseOutcome::Fails;
  bool as_stated = false;
  std::string note;  ///< message (refusal, failure, first cut) or fault
  int steps = 0;
  double error = std::numeric_limits<double>::quiet_NaN();
  double farthest_mm = 0;                            ///< largest final distance from the centre of the start
  int folded = 0, folded_reported = 0;               ///< folded vertices, counted in double, and as reported
  bool inverted = false, inverted_reported = false;  ///< some mesh is inverted, and reported as such
  int cuts = 0;
};
CaseResult run_case(const StabilityCase& stability_case, Solver solver, const EngineFactory& make_engine, bool full);

/// The choices of the parameter `solver`.
std::vector<std::string> solver_names();

}  // namespace simplexseg
