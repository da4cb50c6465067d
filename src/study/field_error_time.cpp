// SPDX-License-Identifier: Apache-2.0
#include "study/field_error_time.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <utility>

#include "core/number_text.h"
#include "field/field_subject.h"
#include "image/metrics.h"
#include "study/forwarding_solver.h"

namespace simplexseg {
namespace {

constexpr int kConvergedAfter = 60;          ///< cycles after which a solution counts as converged
constexpr std::size_t kMostCells = 200'000;  ///< largest number of cells whose probabilities are compared

/// Solver that computes kConvergedAfter cycles of each solution and records the last one. The inner solver must be
/// limited to one cycle a call.
class ConvergenceProbe final : public ForwardingSolver {
 public:
  ConvergenceProbe(std::unique_ptr<FieldSolver> inner, std::vector<SolverSample>& last)
      : ForwardingSolver(std::move(inner)), last_(last) {}

  Solved solve(double, bool further) override {
    if (further) return end_;  // converged before
    last_.clear();
    std::vector<std::vector<float>> fields;
    for (int cycles = 1; cycles <= kConvergedAfter; ++cycles) {
      // Any first correction is within an infinite tolerance.
      end_ = cycles == 1 ? inner().solve(std::numeric_limits<double>::infinity(), false) : inner().solve(0, true);
      if (cycles > 1 && end_.iterations == 0) break;  // converged to the last bit
      last_.push_back({cycles, 0, end_.error});
      fields.push_back(some_probabilities());
    }
    for (std::size_t s = 0; s < last_.size(); ++s)
      for (std::size_t c = 0; c < fields[s].size(); ++c)
        last_[s].error = std::max<double>(last_[s].error, std::fabs(fields[s][c] - fields.back()[c]));
    return end_;
  }

 private:
  std::vector<float> some_probabilities() const {
    const std::span<const float> all = inner().probability();
    const std::size_t step = (all.size() + kMostCells - 1) / kMostCells | 1;  // odd, so that no axis is skipped
    std::vector<float> some;
    for (std::size_t v = 0; v < all.size(); v += step) some.push_back(all[v]);
    return some;
  }

  std::vector<SolverSample>& last_;
  Solved end_;
};

}  // namespace

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::vector<FieldVariant> field_variants() {
  std::vector<FieldVariant> all{{"default", "default", {}}};
  const auto add = [&](const std::string& group, const std::string& value) -> EvidenceSettings& {
    all.push_back({group + " " + value, group, {}});
    return all.back().settings;
  };
  for (const double tolerance : {0.3, 0.1, 0.03, 0.01, 0.003, 0.001})
    add("tolerance", general_text(tolerance, 3)).tolerance = tolerance;
  for (const int iterations : {1, 2, 4, 8})
    add("cycles at most", std::to_string(iterations)).most_iterations = iterations;
  for (const double cells : {2e4, 6e4, 2e5, 6e5, 2.2e6, 8e6})
    add("cells at most", fixed_text(cells, 0)).max_cells = cells;
  return all;
}

std::vector<RobotClick> robot_clicks(const Volume& image, const Mask& truth, int clicks, const RunJobs& run,
                                     const MakeFieldSolver& make) {
  RobotSettings settings;
  settings.most_clicks = clicks;
  FieldSubject<> subject(image, run, {}, make);
  return run_robot(truth, subject, settings, [](int, const Mask&) {});
}

FieldCurve measure_field(const Volume& image, const Mask& truth, const std::vector<Mark>& marks,
                         const FieldVariant& variant, const RunJobs& run, const MakeFieldSolver& make,
                         const StudyClock& clock) {
  FieldCurve curve{variant, {}};
  EvidenceField field(image, run, variant.settings, make);
  for (std::size_t count = 1; count <= marks.size(); ++count) {
    const double start = clock();
    field.update({marks.data(), count});
    const double seconds = clock() - start;
    const Agreement agreement = compare(truth, field.object());
    curve.samples.push_back({seconds, agreement.dice, agreement.assd_mm, field.box().voxel_count(),
                             field.report().iterations, field.report().growths});
  }
  return curve;
}

std::vector<std::vector<SolverSample>> measure_solver(const Volume& image, const std::vector<Mark>& marks,
                                                      const RunJobs& run, const MakeFieldSolver& make) {
  std::vector<SolverSample> last;
  const MakeFieldSolver make_probe = [&](const Volume& volume, const RunJobs& jobs, const EvidenceSettings& settings) {
    EvidenceSettings one_cycle = settings;
    one_cycle.most_iterations = 1;
    return std::make_unique<ConvergenceProbe>(make(volume, jobs, one_cycle), last);
  };
  EvidenceField field(image, run, {}, make_probe);
  std::vector<std::vector<SolverSample>> all;
  for (std::size_t count = 1; count <= marks.size(); ++count) {
    field.update({marks.data(), count});
    all.push_back(last);
  }
  return all;
}

}  // namespace simplexseg
