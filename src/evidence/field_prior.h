// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "evidence/evidence_settings.h"
#include "evidence/mark_classifier.h"
#include "evidence/marked_voxels.h"
#include "evidence/padded_array.h"
#include "evidence/run_jobs.h"

namespace simplexseg {

/// What the prior is made from.
struct PriorInput {
  const BoxGrid& grid;
  const std::array<double, 3>& spacing_mm;
  std::span<const float> image;  ///< smoothed
  const FeatureLists& features;
  std::span<const Known> known;
};

/// 75th percentile of |difference| between neighbours that are both marked as inside, along the axes whose spacing is
/// less than twice the least: what is not an edge of this object. 0 with fewer than 20 pairs.
float inner_difference(const PriorInput& input);

/// P(object) from the looks of the marks and the geodesic distances to them, 0..255 for 0..1.
std::vector<std::uint8_t> field_prior(const PriorInput& input, const EvidenceSettings& settings, const RunJobs& run);

}  // namespace simplexseg
