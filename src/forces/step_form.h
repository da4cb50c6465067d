// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace simplexseg {

/// Update z computed from the force f of a vertex, for its step  x+ = x + momentum (x - x-) + gain z
/// (docs/mathematics.md, section 3).
enum class StepForm : int {
  Plain,      ///< z = f
  Scaled,     ///< z = f / (stiffness bound of the vertex)
  Corrected,  ///< z = result of a multigrid cycle on f
};
/// Coefficients of a step. `momentum`: share of the velocity that remains after damping.
struct StepCoefficients {
  float gain, momentum;
  bool operator==(const StepCoefficients&) const = default;
};

}  // namespace simplexseg
