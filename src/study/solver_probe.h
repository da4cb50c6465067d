// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <limits>

#include "field/make_field_solver.h"

namespace simplexseg {

/// Measurements of the solutions of the random walker of a field.
struct SolverRecord {
  int solves = 0;           ///< number of solutions, one for each pass over a box
  int most_iterations = 0;  ///< largest number of cycles of a solution
  double largest_factor = std::numeric_limits<double>::quiet_NaN();  ///< largest mean factor of the error a cycle
  std::size_t peak_bytes = 0;  ///< largest FieldSolver::bytes() at the end of a function of the solver
};

/// Maker of solvers that measure themselves and give the same results as those of `make`, which they call. `record`
/// must outlive them.
MakeFieldSolver probed(const MakeFieldSolver& make, SolverRecord& record);

}  // namespace simplexseg
