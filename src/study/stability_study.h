// SPDX-License-Identifier: Apache-2.0
// Stability study: every case with every solver, the limits of the timestep, and the reports of both.
#pragma once
#include "session/plot.h"
#include "study/stability_limits.h"

namespace simplexseg {

struct StabilityStudy {
  std::string engine;                          ///< description of the engine
  std::vector<std::vector<CaseResult>> cases;  ///< results by case and solver
  std::vector<StabilityLimit> limits;
  int missed() const;  ///< number of results and limits that differ from the expectation
};
/// Runs the study. `progress` is called before each case, before the limits and at the end with the completed share in
/// [0, 1].
StabilityStudy study_stability(const EngineFactory& make_engine, const std::function<void(double)>& progress);

/// CSV with one line per case and solver.
std::string cases_csv(const StabilityStudy& study);
std::string limits_csv(const StabilityStudy& study);
/// Markdown: expected and observed outcomes by case and solver, differences, limits.
std::string stability_report(const StabilityStudy& study);
/// Plot of the measured and predicted limits against the stiffness.
Plot limits_plot(const StabilityStudy& study);

}  // namespace simplexseg
