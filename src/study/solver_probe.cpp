// SPDX-License-Identifier: Apache-2.0
#include "study/solver_probe.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "study/forwarding_solver.h"

namespace simplexseg {
namespace {

class SolverProbe final : public ForwardingSolver {
 public:
  SolverProbe(std::unique_ptr<FieldSolver> inner, SolverRecord& record)
      : ForwardingSolver(std::move(inner)), record_(record) {}

  void set_box(const CellSize& cell, const VoxelBox& box, double scale_mm) override {
    ForwardingSolver::set_box(cell, box, scale_mm);
    record_bytes();
  }
  double compute_prior(std::span<const Mark> marks, std::span<const NewMarkBall> new_balls, double scale_mm,
                       double radius_mm) override {
    const double beta = inner().compute_prior(marks, new_balls, scale_mm, radius_mm);
    record_bytes();
    return beta;
  }
  Solved solve(double tolerance, bool resume) override {
    if (!resume) {
      ++record_.solves;
      // Any first correction is within an infinite tolerance; continuing gives the bits of one call.
      first_error_ = inner().solve(std::numeric_limits<double>::infinity(), false).error;
      iterations_ = 0;
    }
    Solved solved = inner().solve(tolerance, true);
    iterations_ += solved.iterations;
    record_.most_iterations = std::max(record_.most_iterations, iterations_);
    if (iterations_ > 0 && first_error_ > 0)
      record_.largest_factor =
          std::fmax(record_.largest_factor, std::pow(solved.error / first_error_, 1.0 / iterations_));
    record_bytes();
    return solved;
  }

 private:
  void record_bytes() { record_.peak_bytes = std::max(record_.peak_bytes, inner().bytes()); }

  SolverRecord& record_;
  double first_error_ = 0;
  int iterations_ = 0;
};

}  // namespace

MakeFieldSolver probed(const MakeFieldSolver& make, SolverRecord& record) {
  return [make, &record](const Volume& volume, const RunJobs& run, const EvidenceSettings& settings) {
    return std::make_unique<SolverProbe>(make(volume, run, settings), record);
  };
}

}  // namespace simplexseg
