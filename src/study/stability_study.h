// SPDX-License-Identifier: Apache-2.0
// The whole study: every case with every solver, the limits, and how they are written down.
#pragma once
#include "session/plot.h"
#include "study/stability_limits.h"

namespace simplexseg {

struct StabilityStudy {
  std::string engine;                          ///< its description
  std::vector<std::vector<CaseResult>> cases;  ///< of each case, of each solver
  std::vector<StabilityLimit> limits;
  int missed() const;  ///< cases and limits that are not as stated
};
/// `progress` is called with a share in [0, 1], between cases.
StabilityStudy study_stability(const EngineFactory& make_engine, const std::function<void(double)>& progress);

/// A line for each case and solver.
std::string cases_csv(const StabilityStudy& study);
std::string limits_csv(const StabilityStudy& study);
/// Markdown: cases x solvers with what was stated and why, what missed, limits.
std::string stability_report(const StabilityStudy& study);
/// Limits over stiffness, measured and predicted.
Plot limits_plot(const StabilityStudy& study);

}  // namespace simplexseg
