// SPDX-License-Identifier: Apache-2.0
// Sharpness of the conductances of the random walker.
#pragma once
#include "field/evidence_settings.h"

namespace simplexseg {

inline constexpr double kShareOfDifferences = 0.75;  ///< quantile of the inner difference (fetch_inner_difference())
inline constexpr int kLeastDifferences = 20;         ///< least number of differences for it

/// Sharpness beta of the conductances, per squared intensity, for this inner difference (fetch_inner_difference()).
double sharpness_of(float inner_difference, const EvidenceSettings& settings);

}  // namespace simplexseg
