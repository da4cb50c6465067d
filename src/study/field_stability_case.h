// SPDX-License-Identifier: Apache-2.0
// Stability case of the evidence field: a stiff or extreme image, grid, list of marks or system with its expected
// outcome. The observed outcome is measured from the field and the object, not from the program's own reports.
#pragma once
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "field/make_field_solver.h"
#include "field/walker_system.h"

namespace simplexseg {

/// Solvers of a backend, and how the host part of a field is run.
struct FieldBackend {
  std::string description;
  MakeFieldSolver solver;
  SolveWalkerSystem walker;
  RunJobs run = run_serially();
  int threads = 1;  ///< threads of `run`
};

enum class FieldOutcome {
  Found,      ///< the Dice coefficient of the object and the true one is at least that of the case
  Bounded,    ///< there is no object to find, or a part of it; the object has at most the volume of the case
  Empty,      ///< the object has no voxel
  Stopped,    ///< growth stopped, was reported, and the object has at most the volume of the case
  Steady,     ///< repeated updates change the field by at most the drift of the case
  Converges,  ///< the solution of a system differs from the exact one by at most the tolerance of the case
  Cancelled,  ///< each cancelled update ended in time, and the next one gave the bits of one that was not cancelled
  Refused,    ///< an Error with the reason prevented the update
  Fails,      ///< none of these, or a fault
};
const char* to_string(FieldOutcome outcome);

/// Result of a case on a backend; NaN or 0: not measured.
struct FieldCaseResult {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  FieldOutcome outcome = FieldOutcome::Fails;
  bool as_stated = false;
  std::string note;     ///< message of a refusal, measurement of the case, or fault; empty: none
  double dice = kNone;  ///< of the object and the true one
  double object_mm3 = kNone;
  double least = kNone, largest = kNone;  ///< of all probabilities, or of the solution of a system
  int solves = 0;                         ///< number of solutions of the random walker, one for each pass over a box
  int iterations = 0;                     ///< largest number of cycles of a solution
  double error = kNone;                   ///< largest correction of the last cycle of the last solution
  double factor = kNone;       ///< largest mean factor by which a cycle of a solution reduced the largest correction
  int growths = 0;             ///< of the box in the last update
  std::size_t cells = 0;       ///< of the box
  std::size_t peak_bytes = 0;  ///< largest memory of the solver at the end of one of its functions
  double seconds = 0;          ///< of all updates
};

struct FieldCase {
  std::string name;     ///< name in snake_case
  std::string what;     ///< extreme property of the case
  FieldOutcome stated;  ///< expected outcome
  std::string reason;   ///< reason for the expected outcome, with its tolerance
  std::function<FieldCaseResult(const FieldBackend&)> run;
  bool large = false;  ///< whether it needs gigabytes or a minute, and is left out of the tests
};
/// Runs a case; sets FieldCaseResult::as_stated.
FieldCaseResult run_case(const FieldCase& field_case, const FieldBackend& backend);

/// All cases, in the order of the table.
std::span<const FieldCase> field_stability_cases();

// Cases of each part of the table.
std::vector<FieldCase> field_image_cases();
std::vector<FieldCase> field_grid_cases();
std::vector<FieldCase> field_shape_cases();
std::vector<FieldCase> field_mark_cases();
std::vector<FieldCase> field_solver_cases();

}  // namespace simplexseg
