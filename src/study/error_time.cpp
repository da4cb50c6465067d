// SPDX-License-Identifier: Apache-2.0
#include "study/error_time.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

#include "core/number_text.h"
#include "forces/parameters.h"

namespace simplexseg {
namespace {

constexpr double kEndShare = 1e-4;    ///< share of the initial errors below which a curve ends
constexpr double kRemeasuredS = 0.5;  ///< initial time of each run that is measured again without reading poses, s
constexpr int kRepeats = 3, kBatch = 10;
constexpr int kStallAfter = 400;      ///< number of steps before a curve can count as stalled
constexpr double kStallBelow = 0.03;  ///< share of the initial error above which no curve counts as stalled

/// Settings of a solver to compare; solvers without an entry use the settings of the scene.
struct Setting {
  const char* solver;
  float damping;
  float share;  ///< timestep as a share of Verlet's largest stable one with this damping
};
constexpr Setting kSettings[] = {
    {"verlet", 0.1f, 0.95f}, {"verlet", 0.1f, 0.5f},  {"verlet", 0.3f, 0.95f},
    {"verlet", 0.3f, 0.5f},  {"verlet", 0.9f, 0.95f}, {"verlet", 0.9f, 0.5f},
};
constexpr int kBaseline = 0;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

std::string float_text(float value) { return general_text(static_cast<double>(value), 6); }

struct TimedSteps {
  double seconds;
  StepOutcome outcome;
};
TimedSteps timed_step(Engine& engine, int steps) {
  const double start = now();
  StepOutcome outcome = engine.step(steps);
  return {now() - start, std::move(outcome)};
}

bool has_stalled(const std::vector<FrozenSample>& samples) {
  const std::int64_t steps = samples.back().steps;
  if (steps < kStallAfter || samples.back().whole > kStallBelow) return false;
  double before_whole = 1e300, before_normal = 1e300, whole = 1e300, normal = 1e300;
  for (const FrozenSample& s : samples) {
    whole = std::min(whole, s.whole), normal = std::min(normal, s.normal);
    if (2 * s.steps <= steps) before_whole = whole, before_normal = normal;
  }
  return whole > 0.97 * before_whole && normal > 0.97 * before_normal;
}

/// Cumulative times in seconds at the ends of the batches, after 1, 10, 20 ... steps. `end_mm`: returns the final
/// error.
std::vector<double> batch_times(const FrozenProblem& problem, const Method& method, std::int64_t steps,
                                const EngineFactory& make_engine, double& end_mm) {
  const std::unique_ptr<Engine> engine = make_engine();
  problem.load(*engine, method.simulation);
  std::vector<double> times;
  double total = 0;
  for (std::int64_t done = 0; done < steps;) {
    const std::int64_t next = done == 0 ? 1 : std::min(steps, done / kBatch * kBatch + kBatch);
    total += timed_step(*engine, static_cast<int>(next - done)).seconds;
    times.push_back(total);
    done = next;
  }
  end_mm = problem.error_mm(*engine).whole;
  return times;
}

/// Replaces the times of the samples in the first half second by medians of runs that read no poses, because reading
/// between steps evicts caches. Shifts the times of later samples by the same amount as that of the last replaced
/// sample.
void remeasure_times(const FrozenProblem& problem, FrozenCurve& curve, double binding_s,
                     const EngineFactory& make_engine, const Poll& poll) {
  const auto end = std::find_if(curve.samples.begin() + 1, curve.samples.end(),
                                [](const FrozenSample& s) { return s.seconds > kRemeasuredS; });
  const FrozenSample last = *(end - 1);
  const std::int64_t steps = last.steps;
  if (steps == 0) return;
  std::vector<std::vector<double>> runs;
  for (int r = 0; r < kRepeats; ++r) {
    poll();
    double end_mm = 0;
    runs.push_back(batch_times(problem, curve.method, steps, make_engine, end_mm));
    if (end_mm / problem.start_mm.whole != last.whole) curve.note = "a run that was timed ended elsewhere";
  }
  std::vector<std::pair<std::int64_t, double>> knots{{0, 0.0}};
  for (std::size_t b = 0; b < runs[0].size(); ++b) {
    std::vector<double> each;
    each.reserve(runs.size());
    for (const auto& run : runs) each.push_back(run[b]);
    std::nth_element(each.begin(), each.begin() + kRepeats / 2, each.end());
    const std::int64_t at = b == 0 ? 1 : std::min<std::int64_t>(steps, static_cast<std::int64_t>(b) * kBatch);
    knots.emplace_back(at, std::max(each[kRepeats / 2], knots.back().second));
  }
  for (std::size_t k = 1; k < knots.size(); ++k) knots[k].second = std::max(0.0, knots[k].second - binding_s);
  for (FrozenSample& s : curve.samples) {
    if (s.steps > steps) {
      s.seconds += knots.back().second - last.seconds;
      continue;
    }
    const auto after = std::lower_bound(knots.begin(), knots.end(), s.steps,
                                        [](const auto& knot, std::int64_t n) { return knot.first < n; });
    if (after == knots.begin()) continue;
    const auto before = after - 1;
    const double share =
        static_cast<double>(s.steps - before->first) / static_cast<double>(after->first - before->first);
    s.seconds = before->second + share * (after->second - before->second);
  }
}

}  // namespace

std::vector<Method> methods_for(const FrozenProblem& problem) {
  std::vector<Method> methods;
  const std::vector<std::string> names = solver_names();
  for (std::size_t c = 0; c < names.size(); ++c) {
    bool has_settings = false;
    for (std::size_t k = 0; k < std::size(kSettings); ++k) {
      const Setting& setting = kSettings[k];
      if (names[c] != setting.solver) continue;
      Method method{
          names[c] + ", damping " + float_text(setting.damping) + ", " + float_text(100 * setting.share) + "%",
          static_cast<int>(c), problem.simulation, k == kBaseline};
      method.simulation.solver_choice = static_cast<float>(c);
      method.simulation.damping = setting.damping;
      method.simulation.timestep = setting.share * problem.stable_timestep(setting.damping);
      method.simulation.limit_timestep = 0;
      methods.push_back(method);
      has_settings = true;
    }
    if (has_settings) continue;
    Method method{names[c], static_cast<int>(c), problem.simulation, false};
    method.simulation.solver_choice = static_cast<float>(c);
    methods.push_back(method);
  }
  return methods;
}

double binding_seconds(const FrozenProblem& problem, const EngineFactory& make_engine) {
  const bool points = std::any_of(problem.meshes.begin(), problem.meshes.end(),
                                  [](const FrozenMesh& m) { return !m.points_mm.empty(); });
  if (!points) return 0;
  const std::unique_ptr<Engine> engine = make_engine();
  problem.load(*engine, problem.simulation);
  const double first = timed_step(*engine, 1).seconds;
  return std::max(0.0, first - timed_step(*engine, 1).seconds);
}

FrozenCurve run_frozen(const FrozenProblem& problem, const Method& method, double budget_s, double binding_s,
                       const EngineFactory& make_engine, const Poll& poll) {
  FrozenCurve curve{method, {{0, 0, 1, 1}}, 0, ""};
  const std::unique_ptr<Engine> engine = make_engine();
  problem.load(*engine, method.simulation);
  std::int64_t steps = 0;
  double spent = 0;
  while (spent < budget_s) {
    poll();
    // The batch grows from single steps to a tenth of the steps so far.
    const int batch = steps < 20 ? 1 : static_cast<int>(std::min<std::int64_t>(steps / 10, 1 << 20));
    const double per_step = steps > 0 ? spent / static_cast<double>(steps) : 0;
    const int affordable = per_step > 0 ? static_cast<int>(std::clamp((budget_s - spent) / per_step + 1, 1.0, 1e6)) : 1;
    const TimedSteps part = timed_step(*engine, std::min(batch, affordable));
    steps += part.outcome.steps;
    spent += part.seconds;
    curve.cuts += static_cast<int>(part.outcome.cuts.size());
    if (part.outcome.failure) {
      curve.note = "failed after " + std::to_string(steps) + " steps";
      break;
    }
    const PoseError error = problem.error_mm(*engine);
    curve.samples.push_back({steps, std::max(0.0, spent - binding_s), error.whole / problem.start_mm.whole,
                             error.normal / problem.start_mm.normal});
    const FrozenSample& last = curve.samples.back();
    if (!(last.whole < 1e6)) {
      curve.note = "diverged after " + std::to_string(steps) + " steps";
      break;
    }
    if (std::max(last.whole, last.normal) < kEndShare || has_stalled(curve.samples)) break;
  }
  if (curve.note.empty()) remeasure_times(problem, curve, binding_s, make_engine, poll);
  return curve;
}

std::optional<Reached> reached(const std::vector<FrozenSample>& samples, double share, bool normal_part) {
  std::optional<Reached> first;
  for (const FrozenSample& s : samples) {
    const double error = normal_part ? s.normal : s.whole;
    if (!(error <= share))
      first.reset();
    else if (!first)
      first = Reached{s.steps, s.seconds};
  }
  return first;
}

}  // namespace simplexseg
