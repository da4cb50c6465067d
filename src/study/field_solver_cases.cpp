// SPDX-License-Identifier: Apache-2.0
// Stability cases of the evidence field: systems of the random walker, settings of the solver, and cancellation.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "core/number_text.h"
#include "session/field_updater.h"
#include "study/exact_walker.h"
#include "study/field_trials.h"

namespace simplexseg {
namespace {

using Eigen::Vector3d;
using Clock = std::chrono::steady_clock;

constexpr double kTolerance = 0.01;  ///< of the solver
constexpr double kWrong = 0.03;  ///< largest difference from the exact solution: errors are a few times the tolerance
constexpr int kMostIterations = 60;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Conductance of the edge from cell (i, j, k) along an axis.
using EdgeValue = std::function<double(int axis, int i, int j, int k)>;
/// System of 10^3 cells: the first and the last plane along i are fixed at 1 and 0, the prior is 0.5 with this weight,
/// and x starts at 0.
WalkerSystem system_of(const EdgeValue& edge, double prior_weight) {
  WalkerSystem system;
  system.grid = {{10, 10, 10}};
  const int n = system.grid.count();
  system.prior_weight.assign(n, static_cast<float>(prior_weight));
  system.prior.assign(n, 128);
  system.fixed.assign(n, 0);
  system.start.assign(n, 0);
  for (int axis = 0; axis < 3; ++axis) {
    system.conductance[axis].assign(n, 0);
    for (int v = 0; v < n; ++v) {
      const std::array<int, 3> at{v % 10, v / 10 % 10, v / 100};
      if (at[axis] + 1 < 10) system.conductance[axis][v] = static_cast<float>(edge(axis, at[0], at[1], at[2]));
    }
  }
  for (int v = 0; v < n; ++v)
    if (v % 10 == 0 || v % 10 == 9) system.fixed[v] = 1, system.start[v] = v % 10 == 0 ? 1.0f : 0.0f;
  return system;
}

FieldCase system_case(const char* name, const char* what, const char* reason,
                      const std::function<WalkerSystem()>& make) {
  return {name, what, FieldOutcome::Converges, reason, [make](const FieldBackend& backend) {
            FieldCaseResult result;
            const WalkerSystem system = make();
            const Clock::time_point start = Clock::now();
            const WalkerSolution solution = backend.walker(system, kTolerance, kMostIterations);
            result.seconds = seconds_since(start);
            result.solves = 1, result.iterations = solution.iterations, result.error = solution.error;
            result.cells = solution.x.size(), result.peak_bytes = solution.bytes;
            if (solution.iterations > 0 && solution.first_error > 0)
              result.factor = std::pow(solution.error / solution.first_error, 1.0 / solution.iterations);
            const std::vector<double> exact = exact_walker_solution(system);
            double difference = 0;
            result.least = 1, result.largest = 0;
            for (std::size_t v = 0; v < exact.size(); ++v) {
              if (!std::isfinite(solution.x[v])) {
                result.note = "a value is not finite";
                return result;
              }
              difference = std::max(difference, std::abs(solution.x[v] - exact[v]));
              result.least = std::min<double>(result.least, solution.x[v]);
              result.largest = std::max<double>(result.largest, solution.x[v]);
            }
            result.note = "differs from the exact solution by " + general_text(difference, 2);
            if (difference <= kWrong && result.least >= 0 && result.largest <= 1)
              result.outcome = FieldOutcome::Converges;
            return result;
          }};
}

double log_uniform(FieldNoise& noise, double decades) { return std::pow(10, decades * (noise.uniform() - 0.5)); }

/// Cancels updates of a field after parts of their time, and compares the next update with one that was not cancelled.
FieldCaseResult run_cancelled(const FieldBackend& backend) {
  constexpr int kCancels = 12;
  constexpr double kLatestS = 0.25;
  const FieldTrial trial = trial_with(grid_of({96, 96, 96}), [](const Vector3d& p) { return ball(p / 2); });
  const std::vector<Mark> marks{inside_mark({1, 1, 1}, 12)};
  MeshItem item;
  item.id = 1;
  FieldUpdater updater(backend.threads, {});
  updater.set_solver(backend.solver);
  updater.open(trial.volume);
  FieldCaseResult result;
  const auto update = [&] {
    updater.start(item, marks, {});
    return updater.finish();
  };
  const Clock::time_point start = Clock::now();
  const auto whole = update();
  const double whole_s = seconds_since(start);
  double latest_s = 0;
  int kept = 0;
  for (int n = 0; n < kCancels; ++n) {
    updater.open(trial.volume);  // discards the field, so that each update is the first
    updater.start(item, marks, {});
    std::this_thread::sleep_for(std::chrono::duration<double>(whole_s * (n + 0.5) / kCancels));
    const Clock::time_point cancelled = Clock::now();
    updater.cancel();
    while (!updater.ready()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    latest_s = std::max(latest_s, seconds_since(cancelled));
    if (updater.finish()) ++kept;
  }
  const auto next = update();
  result.seconds = seconds_since(start);
  result.note = "latest end " + general_text(1000 * latest_s, 3) + " ms after the cancellation";
  if (whole && next && kept == 0 && latest_s <= kLatestS && whole->problem.empty() && next->values == whole->values)
    result.outcome = FieldOutcome::Cancelled;
  return result;
}

FieldCase with_settings(const char* name, const char* what, FieldOutcome stated, const char* reason,
                        const EvidenceSettings& settings) {
  return trial_case(name, what, stated, reason, [=] {
    FieldTrial trial = trial_with(usual_grid(), ball);
    trial.updates = {{usual_seed()}};
    trial.settings = settings;
    return trial;
  });
}

}  // namespace

std::vector<FieldCase> field_solver_cases() {
  constexpr auto kExact = "at most .03 from the exact solution: errors are a few times the tolerance .01";
  std::vector<FieldCase> cases;
  const auto uniform = [](double g) { return [g](int, int, int, int) { return g; }; };
  cases.push_back(system_case("conductances_1", "all conductances 1, prior weight 0.1", kExact,
                              [=] { return system_of(uniform(1), 0.1); }));
  cases.push_back(system_case("conductances_1e-30", "all conductances 1e-30, prior weight 1e-31", kExact,
                              [=] { return system_of(uniform(1e-30), 1e-31); }));
  cases.push_back(system_case("conductances_1e30", "all conductances 1e30, prior weight 1e29", kExact,
                              [=] { return system_of(uniform(1e30), 1e29); }));
  for (const int decades : {6, 12, 20, 30}) {
    const std::string name = "conductances_over_" + std::to_string(decades) + "_orders",
                      what =
                          "each conductance random over " + std::to_string(decades) + " orders of magnitude, no prior";
    cases.push_back(system_case(name.c_str(), what.c_str(), kExact, [decades] {
      FieldNoise noise;
      return system_of([&](int, int, int, int) { return log_uniform(noise, decades); }, 0);
    }));
  }
  cases.push_back(
      system_case("prior_over_30_orders", "conductances 1, prior weights random over 30 orders", kExact, [=] {
        WalkerSystem system = system_of(uniform(1), 0);
        FieldNoise noise;
        for (float& weight : system.prior_weight) weight = static_cast<float>(log_uniform(noise, 30));
        return system;
      }));
  cases.push_back(
      system_case("layers_over_30_orders", "planes of conductance 1e15 and 1e-15 in turn, along j", kExact,
                  [] { return system_of([](int, int, int j, int) { return j % 2 == 0 ? 1e15 : 1e-15; }, 0); }));
  cases.push_back(system_case("halves_over_30_orders", "one half of the cells 1e15, the other 1e-15", kExact,
                              [] { return system_of([](int, int, int j, int) { return j < 5 ? 1e15 : 1e-15; }, 0); }));
  cases.push_back(system_case(
      "edges_1e-5", "a wall of conductance 1e-5 between two halves, as beside an edge of the image", kExact,
      [] { return system_of([](int axis, int i, int, int) { return axis == 0 && i == 4 ? 1e-5 : 1.0; }, 0); }));
  cases.push_back(system_case("islands", "islands of conductance 1 that are connected by 1e-8 to the rest", kExact, [] {
    return system_of([](int, int i, int j, int k) { return i % 3 == 2 || j % 3 == 2 || k % 3 == 2 ? 1e-8 : 1.0; }, 0);
  }));
  cases.push_back(system_case("conductances_0", "all conductances 0, no prior", "every cell keeps its start",
                              [=] { return system_of(uniform(0), 0); }));
  cases.push_back(system_case("nothing_fixed", "no cell is fixed, prior weight 1e-3", kExact, [=] {
    WalkerSystem system = system_of(uniform(1), 1e-3);
    std::ranges::fill(system.fixed, std::uint8_t{0});
    return system;
  }));
  cases.push_back(system_case("all_fixed", "all cells are fixed", "every cell keeps its start", [=] {
    WalkerSystem system = system_of(uniform(1), 0.1);
    std::ranges::fill(system.fixed, std::uint8_t{1});
    return system;
  }));
  EvidenceSettings exact, one_iteration, no_prior, few_cells;
  exact.tolerance = 0;
  one_iteration.most_iterations = 1;
  no_prior.prior_weight = 0;
  few_cells.max_cells = 1000;
  cases.push_back(with_settings("tolerance_0", "tolerance 0", FieldOutcome::Found,
                                "Dice at least .95: the solver ends after 60 cycles a solution", exact));
  cases.push_back(with_settings("one_iteration", "one cycle a solution", FieldOutcome::Found,
                                "Dice at least .95: the prior alone finds the ball", one_iteration));
  cases.push_back(with_settings("no_prior", "weight 0 of the prior: conductances alone", FieldOutcome::Found,
                                "Dice at least .95", no_prior));
  FieldCase coarse = trial_case("cells_1000", "at most 1,000 cells", FieldOutcome::Found,
                                "Dice at least .8: cells of 5 voxels", [few_cells] {
                                  FieldTrial trial = trial_with(usual_grid(), ball);
                                  trial.updates = {{usual_seed()}};
                                  trial.settings = few_cells;
                                  trial.least_dice = 0.8;
                                  return trial;
                                });
  cases.push_back(std::move(coarse));
  cases.push_back(
      {"cancel_at_any_time", "12 updates that are cancelled after 1/24 to 23/24 of their time", FieldOutcome::Cancelled,
       "each ends within 250 ms and gives no field; the next update has the bits of the first", run_cancelled});
  return cases;
}

}  // namespace simplexseg
