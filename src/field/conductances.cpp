// SPDX-License-Identifier: Apache-2.0
#include "field/conductances.h"

#include <algorithm>

namespace simplexseg {

double sharpness_of(float inner_difference, const EvidenceSettings& settings) {
  if (settings.sharpness <= 0) return settings.beta;
  const double edge = settings.sharpness * inner_difference;
  return std::clamp(1 / (2 * edge * edge), settings.least_beta, settings.largest_beta);
}

}  // namespace simplexseg
