// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <sstream>

#include "core/number_text.h"
#include "session/run_trace.h"
#include "study/field_error_time.h"

namespace simplexseg {
namespace {

std::string name_of_mark(std::size_t mark) { return mark == 0 ? "seed" : "click " + std::to_string(mark); }

/// Seconds of an update, the median of the clicks.
double click_seconds(const FieldCurve& curve) {
  std::vector<double> seconds;
  for (std::size_t m = 1; m < curve.samples.size(); ++m) seconds.push_back(curve.samples[m].seconds);
  if (seconds.empty()) return 0;
  std::nth_element(seconds.begin(), seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2), seconds.end());
  return seconds[seconds.size() / 2];
}

/// First number of cycles from which on the error is at most `error`; "-" if there is none.
std::string cycles_to(const std::vector<SolverSample>& samples, double error) {
  std::optional<int> first;
  for (const SolverSample& s : samples) {
    if (!(s.error <= error))
      first.reset();
    else if (!first)
      first = s.iterations;
  }
  return first ? std::to_string(*first) : "-";
}

}  // namespace

std::string field_curves_csv(const std::vector<FieldErrorTime>& all) {
  std::ostringstream csv;
  csv << "object,backend,group,variant,mark,seconds,dice,mean_mm,cells,iterations,growths\n";
  for (const FieldErrorTime& one : all)
    for (const FieldCurve& curve : one.curves)
      for (std::size_t m = 0; m < curve.samples.size(); ++m) {
        const FieldSample& s = curve.samples[m];
        csv << csv_field(one.name) << ',' << csv_field(one.backend) << ',' << csv_field(curve.variant.group) << ','
            << csv_field(curve.variant.name) << ',' << m << ',' << general_text(s.seconds, 4) << ','
            << fixed_text(s.dice, 5) << ',' << general_text(s.mean_mm, 5) << ',' << s.cells << ',' << s.iterations
            << ',' << s.growths << '\n';
      }
  return csv.str();
}

std::string field_solver_csv(const std::vector<FieldErrorTime>& all) {
  std::ostringstream csv;
  csv << "object,backend,mark,cycles,error,estimated\n";
  for (const FieldErrorTime& one : all)
    for (std::size_t m = 0; m < one.solver.size(); ++m)
      for (const SolverSample& s : one.solver[m])
        csv << csv_field(one.name) << ',' << csv_field(one.backend) << ',' << m << ',' << s.iterations << ','
            << general_text(s.error, 4) << ',' << general_text(s.estimated, 4) << '\n';
  return csv.str();
}

Plot field_plot(const FieldErrorTime& one, bool distance, bool click) {
  Plot plot{one.name + (click ? ", last click, " : ", seed, ") + one.backend,
            click ? "time from the click (s)" : "time from the seed (s)",
            distance ? "mean surface distance (mm)" : "1 - Dice",
            true,
            true,
            {}};
  for (const FieldCurve& curve : one.curves) {
    if (curve.samples.empty()) continue;
    const std::string& group = curve.variant.group;
    auto series = std::ranges::find_if(plot.series, [&](const PlotSeries& s) { return s.name == group; });
    if (series == plot.series.end()) {
      plot.series.push_back({group, plot_colour(plot.series.size()), true, false, {}, {}});
      series = plot.series.end() - 1;
    }
    const FieldSample& s = click ? curve.samples.back() : curve.samples.front();
    series->x.push_back(s.seconds);
    series->y.push_back(distance ? s.mean_mm : 1 - s.dice);
  }
  return plot;
}

Plot field_solver_plot(const FieldErrorTime& one) {
  Plot plot{one.name + ", random walker, " + one.backend,
            "multigrid cycles",
            "largest difference from the converged solution",
            false,
            true,
            {}};
  for (std::size_t m = 0; m < one.solver.size(); ++m) {
    PlotSeries error{name_of_mark(m), plot_colour(m), true, false, {}, {}},
        estimated{name_of_mark(m) + ", estimate", plot_colour(m), false, true, {}, {}};
    for (const SolverSample& s : one.solver[m]) {
      error.x.push_back(s.iterations), error.y.push_back(s.error);
      estimated.x.push_back(s.iterations), estimated.y.push_back(s.estimated);
    }
    plot.series.push_back(std::move(error));
    plot.series.push_back(std::move(estimated));
  }
  return plot;
}

std::string field_error_time_report(const FieldErrorTime& one) {
  std::ostringstream text;
  text << "## " << one.name << "\n\n"
       << "On " << one.backend << ", the same seed and " << (one.marks.empty() ? 0 : one.marks.size() - 1)
       << " clicks for all settings.\n\n"
       << "| settings | cells | seed: s | cycles | Dice | mean mm | click: s, median | last Dice | mean mm |\n"
       << "|---|---|---|---|---|---|---|---|---|\n";
  for (const FieldCurve& curve : one.curves) {
    if (curve.samples.empty()) continue;
    const FieldSample &seed = curve.samples.front(), &last = curve.samples.back();
    text << "| " << curve.variant.name << " | " << last.cells << " | " << fixed_text(seed.seconds, 2) << " | "
         << seed.iterations << " | " << fixed_text(seed.dice, 4) << " | " << fixed_text(seed.mean_mm, 3) << " | "
         << fixed_text(click_seconds(curve), 3) << " | " << fixed_text(last.dice, 4) << " | "
         << fixed_text(last.mean_mm, 3) << " |\n";
  }
  text << "\nCycles of the last solution until no probability differs by more from the converged one.\n\n"
       << "| mark | 0.1 | 0.03 | 0.01 | 0.003 | 0.001 | estimate 0.01 after | error there |\n"
       << "|---|---|---|---|---|---|---|---|\n";
  for (std::size_t m = 0; m < one.solver.size(); ++m) {
    text << "| " << name_of_mark(m);
    for (const double error : {0.1, 0.03, 0.01, 0.003, 0.001}) text << " | " << cycles_to(one.solver[m], error);
    const double tolerance = EvidenceSettings{}.tolerance;
    const auto stop =
        std::ranges::find_if(one.solver[m], [&](const SolverSample& s) { return s.estimated <= tolerance; });
    if (stop == one.solver[m].end())
      text << " | - | - |\n";
    else
      text << " | " << stop->iterations << " | " << general_text(stop->error, 2) << " |\n";
  }
  text << "\n";
  return text.str();
}

}  // namespace simplexseg
