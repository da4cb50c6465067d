// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace simplexseg {

/// Update z computed from the force f at a vertex (mm), for the step  x+ = x + momentum (x - x-) + gain z  from the
/// positions x- and x (docs/mathematics.md, section 3).
enum class StepForm : int {
  Plain,      ///< z = f
  Scaled,     ///< z = f / (stiffness bound of the vertex)
  Corrected,  ///< z = result of a multigrid V-cycle with the right-hand side f
};
/// Coefficients of a step. `gain`: factor on the update z; `momentum`: share of the last move that is repeated.
struct StepCoefficients {
  float gain, momentum;
  bool operator==(const StepCoefficients&) const = default;
};

}  // namespace simplexseg
