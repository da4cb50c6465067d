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
  Converges,  ///< the final error is at most the tolerance of the case
  Bounded,    ///< every final position is within the reach of the case
  Cut,        ///< steps were undone, the timestep reduced, and a message given; the run ended within reach
  Pauses,     ///< the run stopped with a message that names segmentation and force
  Refused,    ///< an Error with the reason prevented the run
  Fails,      ///< none of these, or a fold or inversion that was not reported or is not allowed
};
const char* to_string(CaseOutcome outcome);

/// Scene and settings that a case runs, and the criteria for its outcome.
struct Trial {
  Scene scene;  ///< every mesh has a pose
  Volume volume;
  bool at_engine = false;  ///< whether no session is used, for values beyond the ranges of the sliders
  int steps = 400;
  int chunk = 0;                               ///< number of steps between calls of `between`; 0: none
  std::function<void(Session&, int)> between;  ///< called with the session and the number of finished chunks
  std::function<double(const Scene&)> error;   ///< error of the final scene; empty: the case has no target
  double tolerance = 0;                        ///< largest error that counts as converged
  double reach_mm = 60;                        ///< largest allowed final distance from the mesh's initial centre
  bool folds = false;                          ///< whether folds may remain at the end; they must be reported
  bool inverted = false;                       ///< whether meshes may be inverted at the end; this must be reported
  bool cuts = false;                           ///< whether steps may be undone; this must be reported
};

struct StabilityCase {
  std::string name;                      ///< name in snake_case
  std::string what;                      ///< extreme property of the case
  CaseOutcome stated, stated_verlet;     ///< expected outcomes; only Verlet uses the given timestep without change
  std::string reason;                    ///< reason for the expected outcome
  std::function<Trial(bool full)> make;  ///< makes the trial; full: in the size of the study, else of the tests
  std::string refusal_text = {};         ///< expected part of the message of a refusal; empty: any message
};

/// All cases, in the order of the table.
std::span<const StabilityCase> stability_cases();

// Cases of each part of the table.
std::vector<StabilityCase> force_cases();
std::vector<StabilityCase> setting_cases();
std::vector<StabilityCase> mesh_cases();
std::vector<StabilityCase> volume_cases();
std::vector<StabilityCase> point_cases();

/// Result of a case with one solver.
struct CaseResult {
  CaseOutcome outcome = CaseOutcome::Fails;
  bool as_stated = false;
  std::string note;  ///< message (refusal, failure, first cut) or fault; empty: none
  int steps = 0;
  double error = std::numeric_limits<double>::quiet_NaN();
  double farthest_mm = 0;                            ///< largest final distance of a vertex from the initial centre
  int folded = 0, folded_reported = 0;               ///< number of folded vertices, counted in double and as reported
  bool inverted = false, inverted_reported = false;  ///< whether some mesh is inverted, and reported as inverted
  int cuts = 0;
};
CaseResult run_case(const StabilityCase& stability_case, Solver solver, const EngineFactory& make_engine, bool full);

/// Names of the solvers: the choices of the parameter `solver`.
std::vector<std::string> solver_names();

}  // namespace simplexseg
