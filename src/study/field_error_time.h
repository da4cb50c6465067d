// SPDX-License-Identifier: Apache-2.0
// Error of the evidence field against run time, for `simplexseg-cli study field-error-time`.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "field/evidence_settings.h"
#include "field/make_field_solver.h"
#include "field/robot_user.h"
#include "image/mask.h"
#include "image/volume.h"
#include "session/plot.h"

namespace simplexseg {

/// Settings of the field to compare.
struct FieldVariant {
  std::string name;
  std::string group;  ///< variants of a group differ in one setting and form a curve
  EvidenceSettings settings;
};
/// The default settings, tolerances from 0.3 to 0.001, limits of the cycles of a solution from 1 to 8, and largest
/// numbers of cells from 20,000 to 8 million.
std::vector<FieldVariant> field_variants();

/// Returns the time of a clock that does not go back, s.
using StudyClock = std::function<double()>;
double wall_seconds();
/// Processor time of all threads of the process. With one thread it is the time on an idle machine, whatever else runs.
double processor_seconds();

/// State after a mark.
struct FieldSample {
  double seconds;           ///< of the update
  double dice, mean_mm;     ///< agreement of the object with the reference: Dice coefficient, mean surface distance
  std::size_t cells;        ///< of the box
  int iterations, growths;  ///< of the update (EvidenceField::Report)
};
struct FieldCurve {
  FieldVariant variant;
  std::vector<FieldSample> samples;  ///< after the seed and each click
};
/// Difference of a solution from the converged one after a number of cycles.
struct SolverSample {
  int iterations;
  double error;      ///< largest difference of a probability before the narrow band
  double estimated;  ///< largest correction, by which the solver decides
};

/// Measurements of one object.
struct FieldErrorTime {
  std::string name;         ///< name of the object
  std::string backend;      ///< processor, its threads, and the clock
  std::vector<Mark> marks;  ///< seed and clicks, the same for all variants
  std::vector<FieldCurve> curves;
  std::vector<std::vector<SolverSample>> solver;  ///< last solution of the updates after the seed and each click
};
/// Clicks of the robot user on the default field of an object: the seed and at most `clicks` corrections.
std::vector<RobotClick> robot_clicks(const Volume& image, const Mask& truth, int clicks, const RunJobs& run,
                                     const MakeFieldSolver& make);
/// Updates a field with the marks, one after the other. `truth`: largest part of the reference.
FieldCurve measure_field(const Volume& image, const Mask& truth, const std::vector<Mark>& marks,
                         const FieldVariant& variant, const RunJobs& run, const MakeFieldSolver& make,
                         const StudyClock& clock);
/// Errors of the last solution of each update against its cycles. The converged solution is that after 60 cycles.
std::vector<std::vector<SolverSample>> measure_solver(const Volume& image, const std::vector<Mark>& marks,
                                                      const RunJobs& run, const MakeFieldSolver& make);

/// CSV with a line per object, variant and mark: object, backend, group, variant, mark, seconds, dice, mean_mm, cells,
/// iterations, growths.
std::string field_curves_csv(const std::vector<FieldErrorTime>& all);
/// CSV with a line per object, mark and number of cycles: object, backend, mark, iterations, error, estimated.
std::string field_solver_csv(const std::vector<FieldErrorTime>& all);
/// Plot against the seconds from a mark: 1 - Dice, or the mean surface distance, mm. `click`: the last mark instead of
/// the seed.
Plot field_plot(const FieldErrorTime& one, bool distance, bool click);
Plot field_solver_plot(const FieldErrorTime& one);
/// Markdown section of an object.
std::string field_error_time_report(const FieldErrorTime& one);

}  // namespace simplexseg
