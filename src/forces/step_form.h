// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace simplexseg {

/// How the force f of a vertex becomes its step  x+ = x + keep (x - x-) + gain z  (docs/mathematics.md, section 3).
enum class StepForm : int {
  Plain,      ///< z = f
  Scaled,     ///< z = f over the vertex's own stiffness bound
  Corrected,  ///< z = a multigrid cycle on f
};
struct StepCoefficients {
  float gain, keep;
  bool operator==(const StepCoefficients&) const = default;
};

}  // namespace simplexseg
