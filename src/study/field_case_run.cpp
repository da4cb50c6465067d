// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/number_text.h"
#include "field/evidence_field.h"
#include "image/metrics.h"
#include "study/field_trials.h"
#include "study/solver_probe.h"

namespace simplexseg {
namespace {

constexpr double kLimitS = 120;               ///< an update that takes longer has no end
constexpr std::size_t kMostVoxels = 1 << 26;  ///< largest volume whose object is computed on its own grid

using Clock = std::chrono::steady_clock;
struct TimeLimitReached {};

/// Largest change of a probability between two fields; 1 if their boxes differ.
double change(std::span<const float> before, const EvidenceField& field) {
  if (before.size() != field.probability().size()) return 1;
  double largest = 0;
  for (std::size_t v = 0; v < before.size(); ++v)
    largest = std::max<double>(largest, std::fabs(before[v] - field.probability()[v]));
  return largest;
}

/// Description of the first mark that the object contradicts; empty: none. A mark whose centre lies near a later mark
/// or in a voxel that is not finite is not examined.
std::string contradicted_mark(const Mask& object, const FieldTrial& trial) {
  const VolumeGeometry& grid = object.geometry;
  const std::vector<Mark>& marks = trial.updates.back();
  for (std::size_t m = 0; m < marks.size(); ++m) {
    const Mark& mark = marks[m];
    if (mark.kind == MarkKind::Boundary) continue;
    const bool covered =
        std::any_of(marks.begin() + static_cast<std::ptrdiff_t>(m) + 1, marks.end(), [&](const Mark& later) {
          return (later.position_mm - mark.position_mm).norm() <= 2 * later.radius_mm + grid.spacing_mm.maxCoeff();
        });
    if (covered) continue;
    const Eigen::Array3d index = (grid.index_from_world() * mark.position_mm).array().round();
    std::array<int, 3> at;
    for (int a = 0; a < 3; ++a) at[a] = std::clamp(static_cast<int>(index[a]), 0, grid.size[a] - 1);
    if (!std::isfinite(static_cast<float>(trial.volume.value(at[0], at[1], at[2])))) continue;
    if ((object.voxels[trial.volume.offset(at[0], at[1], at[2])] != 0) != (mark.kind == MarkKind::Inside))
      return "the object contradicts mark " + std::to_string(m + 1);
  }
  return "";
}

/// Fault that makes the case fail whatever is stated; empty: none.
std::string find_fault(const EvidenceField& field, FieldCaseResult& result) {
  result.least = 1, result.largest = 0;
  for (const float p : field.probability()) {
    if (!std::isfinite(p)) return "a probability is not finite";
    result.least = std::min<double>(result.least, p), result.largest = std::max<double>(result.largest, p);
  }
  if (result.least < 0 || result.largest > 1) return "a probability is not in 0..1";
  if (!std::isfinite(field.report().error)) return "the error of the solver is not finite";
  if (!std::isfinite(field.report().expected_dice)) return "the expected Dice coefficient is not finite";
  return "";
}

FieldOutcome outcome_of(const EvidenceField& field, const FieldTrial& trial, double drift, FieldCaseResult& result) {
  std::size_t count = 0;
  if (trial.volume.geometry().voxel_count() <= kMostVoxels) {
    const Mask object = field.object();
    count = static_cast<std::size_t>(std::ranges::count(object.voxels, std::uint8_t{1}));
    result.object_mm3 =
        static_cast<double>(count) * std::abs(object.geometry.world_from_index().linear().determinant());
    if (field.cell() == kVoxelCells) result.note = contradicted_mark(object, trial);
    if (!result.note.empty()) return FieldOutcome::Fails;
    if (trial.truth) result.dice = dice(*trial.truth, object);
  } else {
    count = field.object_in_box().count;
    result.object_mm3 =
        static_cast<double>(count) * cell_geometry(trial.volume.geometry(), field.cell()).spacing_mm.prod();
  }
  if (trial.drift > 0) {
    result.note = "largest change of a probability " + general_text(drift, 3);
    return drift <= trial.drift ? FieldOutcome::Steady : FieldOutcome::Fails;
  }
  if (result.object_mm3 > trial.most_mm3) {
    result.note =
        "the object has " + general_text(result.object_mm3, 4) + " mm3, more than " + general_text(trial.most_mm3, 4);
    return FieldOutcome::Fails;
  }
  if (field.report().stopped) return FieldOutcome::Stopped;
  if (count == 0) return FieldOutcome::Empty;
  if (!trial.truth) return FieldOutcome::Bounded;
  if (result.dice >= trial.least_dice) return FieldOutcome::Found;
  result.note = "Dice " + fixed_text(result.dice, 3) + " is below " + fixed_text(trial.least_dice, 3);
  return FieldOutcome::Fails;
}

}  // namespace

FieldCaseResult run_trial(const FieldTrial& trial, const FieldBackend& backend) {
  FieldCaseResult result;
  SolverRecord record;
  Clock::time_point start;
  const auto stop_at_limit = [&] {
    if (std::chrono::duration<double>(Clock::now() - start).count() > kLimitS) throw TimeLimitReached();
  };
  const RunJobs run = [&](int jobs, const std::function<void(int)>& job) {
    stop_at_limit();
    backend.run(jobs, job);
  };
  try {
    EvidenceField field(trial.volume, run, trial.settings, probed(backend.solver, record));
    double drift = 0;
    for (std::size_t u = 0; u < trial.updates.size(); ++u) {
      std::vector<float> before;
      if (trial.drift > 0) before.assign(field.probability().begin(), field.probability().end());
      start = Clock::now();
      field.update(trial.updates[u], trial.others, [&](float) { stop_at_limit(); });
      result.seconds += std::chrono::duration<double>(Clock::now() - start).count();
      if (trial.drift > 0 && u > 1) drift = std::max(drift, change(before, field));
    }
    result.growths = field.report().growths;
    result.cells = field.box().voxel_count();
    result.error = field.report().error;
    result.note = find_fault(field, result);
    if (result.note.empty()) result.outcome = outcome_of(field, trial, drift, result);
  } catch (const TimeLimitReached&) {
    result.note = "an update did not end within " + general_text(kLimitS, 3) + " s";
  } catch (const Error& error) {
    result.note = error.what();
    const bool as_expected = trial.refusal_text.empty() || result.note.find(trial.refusal_text) != std::string::npos;
    if (as_expected && result.note.find('\n') == std::string::npos) result.outcome = FieldOutcome::Refused;
  }
  result.solves = record.solves, result.iterations = record.most_iterations;
  result.factor = record.largest_factor, result.peak_bytes = record.peak_bytes;
  return result;
}

FieldCaseResult run_case(const FieldCase& field_case, const FieldBackend& backend) {
  FieldCaseResult result = field_case.run(backend);
  result.as_stated = result.outcome == field_case.stated;
  return result;
}

const char* to_string(FieldOutcome outcome) {
  switch (outcome) {
    case FieldOutcome::Found:
      return "found";
    case FieldOutcome::Bounded:
      return "bounded";
    case FieldOutcome::Empty:
      return "empty";
    case FieldOutcome::Stopped:
      return "stopped";
    case FieldOutcome::Steady:
      return "steady";
    case FieldOutcome::Converges:
      return "converges";
    case FieldOutcome::Cancelled:
      return "cancelled";
    case FieldOutcome::Refused:
      return "refused";
    case FieldOutcome::Fails:
      break;
  }
  return "fails";
}

std::span<const FieldCase> field_stability_cases() {
  static const std::vector<FieldCase> all = [] {
    std::vector<FieldCase> list;
    for (auto part : {field_image_cases, field_grid_cases, field_shape_cases, field_mark_cases, field_solver_cases})
      for (FieldCase& one : part()) list.push_back(std::move(one));
    return list;
  }();
  return all;
}

}  // namespace simplexseg
