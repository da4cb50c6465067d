// SPDX-License-Identifier: Apache-2.0
#include "study/stability_study.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

std::string quoted_field(const std::string& text) {
  std::string field = "\"";
  for (char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + "\"";
}
CaseOutcome stated_outcome(const StabilityCase& one, std::size_t solver) {
  return static_cast<Solver>(solver) == Solver::Verlet ? one.stated_verlet : one.stated;
}
std::string number(double value, int digits = 4) {
  if (std::isnan(value)) return "";
  std::ostringstream text;
  text.precision(digits);
  text << value;
  return text.str();
}
std::string timestep(double value) { return std::isinf(value) ? "none" : number(value); }
std::string difference(const StabilityLimit& limit) {
  if (std::isinf(limit.predicted) || std::isinf(limit.measured)) return "";
  std::ostringstream text;
  text << std::showpos << std::round(1000 * limit.difference()) / 10 << "%";
  return text.str();
}

}  // namespace

int StabilityStudy::missed() const {
  int missed = 0;
  for (const auto& results : cases)
    missed += static_cast<int>(
        std::count_if(results.begin(), results.end(), [](const CaseResult& r) { return !r.as_stated; }));
  return missed + static_cast<int>(std::count_if(limits.begin(), limits.end(),
                                                 [](const StabilityLimit& l) { return !l.as_predicted(); }));
}

StabilityStudy study_stability(const EngineFactory& make_engine, const std::function<void(double)>& progress) {
  StabilityStudy study;
  study.engine = make_engine()->description();
  const std::size_t solvers = solver_names().size(), count = stability_cases().size();
  for (const StabilityCase& one : stability_cases()) {
    progress(static_cast<double>(study.cases.size()) / static_cast<double>(count + 1));
    std::vector<CaseResult> results;
    for (std::size_t s = 0; s < solvers; ++s)
      results.push_back(run_case(one, static_cast<Solver>(s), make_engine, true));
    study.cases.push_back(std::move(results));
  }
  progress(static_cast<double>(count) / static_cast<double>(count + 1));
  study.limits = stability_limits(make_engine);
  progress(1);
  return study;
}

std::string cases_csv(const StabilityStudy& study) {
  std::ostringstream csv;
  csv << "case,solver,stated,observed,as_stated,steps,error,farthest_mm,folded,folded_said,inside_out,inside_out_said,"
         "cuts,said\n";
  const std::vector<std::string> solvers = solver_names();
  for (std::size_t c = 0; c < study.cases.size(); ++c)
    for (std::size_t s = 0; s < study.cases[c].size(); ++s) {
      const StabilityCase& one = stability_cases()[c];
      const CaseResult& r = study.cases[c][s];
      csv << one.name << ',' << solvers[s] << ',' << to_string(stated_outcome(one, s)) << ',' << to_string(r.outcome)
          << ',' << (r.as_stated ? "yes" : "no") << ',' << r.steps << ',' << number(r.error) << ','
          << number(r.farthest_mm) << ',' << r.folded << ',' << r.folded_reported << ',' << r.inverted << ','
          << r.inverted_reported << ',' << r.cuts << ',' << quoted_field(r.note) << '\n';
    }
  return csv.str();
}

std::string limits_csv(const StabilityStudy& study) {
  std::ostringstream csv;
  csv << "force,damping,predicted,measured,difference,as_predicted\n";
  for (const StabilityLimit& l : study.limits)
    csv << quoted_field(l.problem) << ',' << l.damping << ',' << timestep(l.predicted) << ',' << timestep(l.measured)
        << ',' << difference(l) << ',' << (l.as_predicted() ? "yes" : "no") << '\n';
  return csv.str();
}

std::string stability_report(const StabilityStudy& study) {
  std::ostringstream text;
  const std::vector<std::string> solvers = solver_names();
  text << "# Stability\n\nMade by `simplexseg-cli study stability`; engine: " << study.engine << ". "
       << stability_cases().size() << " cases with " << solvers.size() << " solvers, " << study.limits.size()
       << " limits, " << (study.missed() == 0 ? "all as stated" : std::to_string(study.missed()) + " not as stated")
       << ".\n\n"
       << "Stated and observed outcomes: **converges** (the error named under \"why\" ends within its tolerance), "
          "**bounded** "
          "(every position\nstays within the case's reach), **cut** (a step was undone, the timestep cut, the user "
          "told; the run "
          "went on), **pauses** (mesh\nand force named), **refused** (with a message). Where *bounded* is stated, "
          "*converges* will do. "
          "Finite positions, reach, folds\nand orientation are measured in double on the host. A position that is not "
          "finite, or a "
          "fold or an inside-out mesh that is\nnot reported, **fails** whatever is stated. Numbers in brackets: "
          "vertices left on folds, "
          "reported.\n\n## Cases\n\n| case | what | stated | why";
  for (const std::string& solver : solvers) text << " | " << solver;
  text << " |\n|---|---|---|---";
  for (std::size_t s = 0; s < solvers.size(); ++s) text << "|---";
  text << "|\n";
  std::ostringstream missed;
  for (std::size_t c = 0; c < study.cases.size(); ++c) {
    const StabilityCase& one = stability_cases()[c];
    text << "| " << one.name << " | " << one.what << " | " << to_string(one.stated);
    if (one.stated_verlet != one.stated) text << "; verlet: " << to_string(one.stated_verlet);
    text << " | " << one.reason;
    for (std::size_t s = 0; s < study.cases[c].size(); ++s) {
      const CaseResult& r = study.cases[c][s];
      text << " | " << (r.as_stated ? "" : "**") << to_string(r.outcome) << (r.as_stated ? "" : "**");
      if (r.folded > 0) text << " (" << r.folded << ")";
      if (!r.as_stated)
        missed << "- " << one.name << ", " << solvers[s] << ": "
               << (r.note.empty() ? "error " + number(r.error) : r.note) << "\n";
    }
    text << " |\n";
  }
  if (!missed.str().empty()) text << "\n### Not as stated\n\n" << missed.str();
  text
      << "\n## Limits of the timestep\n\nThe largest timestep at which a small deviation from a fixed point of the "
         "force does not "
         "grow, by bisection to 0.5%, and\nsqrt((4 - 2 damping) / stiffness) with the stiffness that the force "
         "reports. The weight is 0.8. "
         "The bound of smoothing is met where\nall edges of a vertex lie in line: a honeycomb around a very thin ring. "
         "The other solvers choose their own steps.\n\n"
         "| force | damping | predicted | measured | difference |\n|---|---|---|---|---|\n";
  for (const StabilityLimit& l : study.limits)
    text << "| " << l.problem << " | " << l.damping << " | " << timestep(l.predicted) << " | "
         << (l.as_predicted() ? "" : "**") << timestep(l.measured) << (l.as_predicted() ? "" : "**") << " | "
         << difference(l) << " |\n";
  return text.str();
}

Plot limits_plot(const StabilityStudy& study) {
  Plot plot{"Largest stable timestep of Verlet", "stiffness that the forces report", "timestep", true, true, {}};
  for (const double damping : kLimitDampings) {
    const Colour colour = plot_colour(plot.series.size() / 2);
    std::ostringstream name;
    name << "damping " << damping;
    PlotSeries bound{name.str() + ", bound", colour, false, true, {}, {}},
        found{name.str() + ", measured", colour, true, false, {}, {}};
    std::vector<std::pair<double, double>> bounds;
    for (const StabilityLimit& l : study.limits) {
      if (l.damping != damping || !std::isfinite(l.predicted) || !std::isfinite(l.measured)) continue;
      const double stiffness = (4 - 2 * damping) / (l.predicted * l.predicted);
      bounds.emplace_back(stiffness, l.predicted);
      // NaN interrupts the line, so that only markers are drawn.
      for (const double x : {stiffness, std::nan("")}) found.x.push_back(x);
      for (const double y : {l.measured, std::nan("")}) found.y.push_back(y);
    }
    std::sort(bounds.begin(), bounds.end());
    for (const auto& [x, y] : bounds) bound.x.push_back(x), bound.y.push_back(y);
    plot.series.push_back(std::move(bound));
    plot.series.push_back(std::move(found));
  }
  return plot;
}

}  // namespace simplexseg
