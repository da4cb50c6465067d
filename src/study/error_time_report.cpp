// SPDX-License-Identifier: Apache-2.0
#include "study/error_time_report.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/number_text.h"
#include "session/run_trace.h"

namespace simplexseg {
namespace {

constexpr double kShares[] = {0.1, 0.01, 0.001};
constexpr int kMiddleInterval = 3;
constexpr double kMaxShown = 10;  ///< largest share of the initial error in plots; larger ones would flatten the rest

/// Number without an exponent: three significant digits from 1 to 1000, an integer above, three decimals below.
std::string short_number(double value) {
  return fixed_text(value, value >= 100 || value == 0 ? 0 : value >= 10 ? 1 : value >= 1 ? 2 : 3);
}

const char* start_name(const LiveVariant& variant) { return variant.coarse_to_fine ? "coarse to fine" : "final level"; }

/// Mean over the meshes with a reference, for each sample; all meshes are sampled at the same times.
template <class Value>
std::vector<double> mean_over_meshes(const LiveCurve& curve, Value&& value) {
  std::vector<double> means;
  double count = 0;
  for (const std::vector<LiveSample>& mesh : curve.meshes) {
    if (mesh.empty()) continue;
    means.resize(mesh.size(), 0.0);
    for (std::size_t s = 0; s < mesh.size(); ++s) means[s] += value(mesh[s]);
    ++count;
  }
  for (double& mean : means) mean /= count;
  return means;
}

PlotSeries live_series(const LiveCurve& curve, const std::string& name) {
  PlotSeries series;
  series.name = name;
  series.dashed = !curve.variant.coarse_to_fine;
  series.markers = true;
  series.x = mean_over_meshes(curve, [](const LiveSample& s) { return s.seconds; });
  series.y = mean_over_meshes(curve, [](const LiveSample& s) { return s.error.mean_mm; });
  return series;
}

void frozen_table(std::ostream& out, const ErrorTimeResult& result, bool normal_part) {
  out << "| method | steps to 10% | ms | ratio | steps to 1% | ms | ratio | steps to 0.1% | ms | ratio | ends at |\n"
      << "|---|---|---|---|---|---|---|---|---|---|---|\n";
  const auto baseline =
      std::find_if(result.frozen.begin(), result.frozen.end(), [](const FrozenCurve& c) { return c.method.baseline; });
  for (const FrozenCurve& curve : result.frozen) {
    out << "| " << curve.method.name << (curve.method.baseline ? " (the measure)" : "");
    for (const double share : kShares) {
      const std::optional<Reached> own = reached(curve.samples, share, normal_part);
      if (!own) {
        out << " | - | - | -";
        continue;
      }
      out << " | " << own->steps << " | " << short_number(1000 * own->seconds) << " | ";
      const std::optional<Reached> measure =
          baseline == result.frozen.end() ? std::nullopt : reached(baseline->samples, share, normal_part);
      if (measure)
        out << short_number(measure->seconds / std::max(own->seconds, 1e-9));
      else if (baseline != result.frozen.end() && baseline->note.empty())
        out << "> " << short_number(baseline->samples.back().seconds / std::max(own->seconds, 1e-9));
      else
        out << "-";
    }
    const FrozenSample& last = curve.samples.back();
    out << " | " << scientific_text(normal_part ? last.normal : last.whole, 1);
    if (curve.cuts > 0) out << ", timestep cut " << curve.cuts << (curve.cuts == 1 ? " time" : " times");
    if (!curve.note.empty()) out << ", " << curve.note;
    out << " |\n";
  }
}

}  // namespace

std::string frozen_csv(const ErrorTimeResult& result) {
  std::ostringstream out;
  out << "scene,backend,method,solver,damping,timestep,steps,seconds,error,normal_error\n";
  const std::vector<std::string> solvers = solver_names();
  for (const FrozenCurve& curve : result.frozen)
    for (const FrozenSample& s : curve.samples)
      out << csv_field(result.name) << ',' << result.backend << ',' << csv_field(curve.method.name) << ','
          << solvers[static_cast<std::size_t>(curve.method.solver)] << ',' << curve.method.simulation.damping << ','
          << curve.method.simulation.timestep << ',' << s.steps << ',' << s.seconds << ',' << s.whole << ',' << s.normal
          << '\n';
  return out.str();
}

std::string live_csv(const ErrorTimeResult& result) {
  std::ostringstream out;
  out << "scene,backend,solver,refresh_interval,start,mesh,steps,seconds,vertices,error_mean_mm,error_p95_mm,error_max_"
         "mm,dice\n";
  const std::vector<std::string> solvers = solver_names();
  for (const LiveCurve& curve : result.live)
    for (std::size_t k = 0; k < curve.meshes.size(); ++k)
      for (const LiveSample& s : curve.meshes[k])
        out << csv_field(result.name) << ',' << result.backend << ','
            << solvers[static_cast<std::size_t>(curve.variant.solver)] << ',' << curve.variant.refresh_interval << ','
            << start_name(curve.variant) << ',' << csv_field(result.mesh_names[k]) << ',' << s.steps << ',' << s.seconds
            << ',' << s.vertices << ',' << s.error.mean_mm << ',' << s.error.p95_mm << ',' << s.error.max_mm << ','
            << s.dice << '\n';
  return out.str();
}

Plot frozen_plot(const ErrorTimeResult& result, bool against_steps, bool normal_part) {
  Plot plot;
  plot.title = result.name + ", frozen targets, " + std::to_string(result.vertices) + " vertices, " + result.backend;
  plot.x_title = against_steps ? "steps" : "time of the steps (s)";
  plot.y_title =
      std::string(normal_part ? "distance along normals" : "distance") + " to the fixed point, share of the start's";
  plot.log_x = plot.log_y = true;
  for (const FrozenCurve& curve : result.frozen) {
    PlotSeries series;
    series.name = curve.method.name;
    series.colour = plot_colour(static_cast<std::size_t>(curve.method.solver));
    series.markers = true;
    series.dashed = curve.method.simulation.limit_timestep == 0 && !curve.method.baseline;
    for (const FrozenSample& s : curve.samples) {
      series.x.push_back(against_steps ? static_cast<double>(s.steps) : s.seconds);
      const double error = normal_part ? s.normal : s.whole;
      series.y.push_back(error < kMaxShown ? error : std::nan(""));
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

Plot live_plot(const ErrorTimeResult& result) {
  Plot plot{result.name + ", whole run, targets refreshed every " + std::to_string(kMiddleInterval) + " steps, " +
                result.backend,
            "time of the simulation (s)",
            "mean distance to the reference (mm)",
            true,
            true,
            {}};
  const std::vector<std::string> solvers = solver_names();
  for (const LiveCurve& curve : result.live) {
    if (curve.variant.refresh_interval != kMiddleInterval) continue;
    PlotSeries series =
        live_series(curve, solvers[static_cast<std::size_t>(curve.variant.solver)] + ", " + start_name(curve.variant));
    series.colour = plot_colour(static_cast<std::size_t>(curve.variant.solver));
    plot.series.push_back(std::move(series));
  }
  return plot;
}

Plot refresh_plot(const ErrorTimeResult& result) {
  Plot plot{result.name + ", whole run, solver " + solver_names().front() + ", " + result.backend,
            "time of the simulation (s)",
            "mean distance to the reference (mm)",
            true,
            true,
            {}};
  std::vector<int> intervals;
  for (const LiveCurve& curve : result.live) {
    if (curve.variant.solver != 0) continue;
    const auto known = std::find(intervals.begin(), intervals.end(), curve.variant.refresh_interval);
    const auto colour = static_cast<std::size_t>(known - intervals.begin());
    if (known == intervals.end()) intervals.push_back(curve.variant.refresh_interval);
    const int interval = curve.variant.refresh_interval;
    PlotSeries series = live_series(
        curve, (interval == 1 ? std::string("every step, ") : "every " + std::to_string(interval) + " steps, ") +
                   start_name(curve.variant));
    series.colour = plot_colour(colour);
    plot.series.push_back(std::move(series));
  }
  return plot;
}

std::string markdown(const ErrorTimeResult& result) {
  std::ostringstream out;
  out << "## " << result.name << "\n\n"
      << "On " << result.backend << " (" << result.device << "). " << result.vertices << " vertices, "
      << general_text(result.start_mm.whole, 4) << " mm (along normals " << general_text(result.start_mm.normal, 4)
      << " mm) from the fixed point at the start; the fixed point was " << result.how << ".\n\n"
      << "Frozen targets, root mean square distance to the fixed point. Ratio: how many times sooner than the "
         "measure.\n\n";
  frozen_table(out, result, false);
  out << "\nThe part of it along the normals.\n\n";
  frozen_table(out, result, true);
  if (!result.live.empty()) {
    out << "\nWhole runs, from the seeds to rest or the scene's last step.\n\n"
        << "| solver | start | refreshed every | steps | ms | mean mm | 95% mm | largest mm | Dice "
           "|\n|---|---|---|---|---|---|---|---|---|\n";
    const std::vector<std::string> solvers = solver_names();
    for (const LiveCurve& curve : result.live) {
      const auto last = [&](auto&& value) {
        const std::vector<double> all = mean_over_meshes(curve, value);
        return all.empty() ? 0.0 : all.back();
      };
      out << "| " << solvers[static_cast<std::size_t>(curve.variant.solver)] << " | " << start_name(curve.variant)
          << " | " << curve.variant.refresh_interval << " | "
          << fixed_text(last([](const LiveSample& s) { return static_cast<double>(s.steps); }), 0)
          << (curve.at_rest ? ", settled" : "") << " | "
          << short_number(1000 * last([](const LiveSample& s) { return s.seconds; })) << " | "
          << fixed_text(last([](const LiveSample& s) { return s.error.mean_mm; }), 3) << " | "
          << fixed_text(last([](const LiveSample& s) { return s.error.p95_mm; }), 3) << " | "
          << fixed_text(last([](const LiveSample& s) { return s.error.max_mm; }), 2) << " | "
          << fixed_text(last([](const LiveSample& s) { return s.dice; }), 4) << " |\n";
    }
  }
  out << "\n";
  return out.str();
}

}  // namespace simplexseg
