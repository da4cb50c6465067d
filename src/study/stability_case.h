// SPDX-License-Identifier: Apache-2.0
// A stiff or extreme case: what it runs, and the outcome that is stated for it. The outcome that is observed is
// measured apart from what the program says of itself.
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
  Converges,  ///< the case's error ends within its tolerance
  Bounded,    ///< every position stays within the case's reach
  Cut,        ///< a step was undone, its timestep cut and the user told; the run went on to its end, within reach
  Pauses,     ///< the run stopped, naming mesh and force
  Refused,    ///< nothing was run: an Error says why
  Fails,      ///< none of these, or a fold or an inside-out mesh that was not reported
};
const char* to_string(CaseOutcome outcome);

/// What a case runs.
struct Trial {
  Scene scene;  ///< every mesh with a pose of its own
  Volume volume;
  bool at_engine = false;  ///< values beyond the sliders' ranges: the engine without a session
  int steps = 400;
  int chunk = 0;                               ///< > 0: `between` is called after every so many steps
  std::function<void(Session&, int)> between;  ///< with the count of chunks done
  std::function<double(const Scene&)> error;   ///< of the end; none: the case has no target
  double tolerance = 0;                        ///< largest error that counts as converged
  double reach_mm = 60;                        ///< largest distance of a vertex from the start's centre, at the end
  bool folds = false;                          ///< folds may be left at the end: they are to be reported
  bool inside_out = false;                     ///< the same for a mesh turned inside out
  bool cuts = false;                           ///< steps may be undone on the way: that is to be said
};

struct StabilityCase {
  std::string name;                      ///< snake_case
  std::string what;                      ///< what is extreme about it
  CaseOutcome stated, stated_verlet;     ///< Verlet alone takes the timestep as it is given
  std::string reason;                    ///< why this is the outcome
  std::function<Trial(bool full)> make;  ///< full: at the size of the study, else at that of the tests
  std::string says = {};                 ///< part of what a refusal says
};

/// All cases, in the order of the table.
std::span<const StabilityCase> stability_cases();

// The parts of the table.
std::vector<StabilityCase> force_cases();
std::vector<StabilityCase> setting_cases();
std::vector<StabilityCase> mesh_cases();
std::vector<StabilityCase> volume_cases();
std::vector<StabilityCase> point_cases();

/// What came of a case with one solver.
struct CaseResult {
  CaseOutcome outcome = CaseOutcome::Fails;
  bool as_stated = false;
  std::string note;  ///< what was said (refusal, failure, first cut), or how it fails
  int steps = 0;
  double error = std::numeric_limits<double>::quiet_NaN();
  double farthest_mm = 0;                            ///< from the start's centre, at the end
  int folded = 0, folded_said = 0;                   ///< vertices, counted in double; as the program says
  bool inside_out = false, inside_out_said = false;  ///< of any mesh
  int cuts = 0;
};
CaseResult run_case(const StabilityCase& stability_case, Solver solver, const EngineFactory& make_engine, bool full);

/// The choices of the parameter `solver`.
std::vector<std::string> solver_names();

}  // namespace simplexseg
