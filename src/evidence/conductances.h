// SPDX-License-Identifier: Apache-2.0
// The random walker's edges, from the image.
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "evidence/evidence_settings.h"
#include "evidence/marked_voxels.h"
#include "evidence/random_walker.h"

namespace simplexseg {

inline constexpr double kShareOfDifferences = 0.75;  ///< inner_difference() is larger than so many
inline constexpr int kLeastDifferences = 20;         ///< that it is taken of

/// 75th percentile of |difference| between neighbours that are both marked as inside, along the axes whose spacing is
/// less than twice the least: what is not an edge of this object. 0 with fewer than 20 pairs.
float inner_difference(const BoxGrid& grid, const std::array<double, 3>& spacing_mm, std::span<const float> image,
                       std::span<const Constraint> known);

/// Sharpness beta of the conductances for such differences within the object, by EvidenceSettings.
double sharpness_of(float inner_difference, const EvidenceSettings& settings);

/// Conductances exp(-beta d^2) (least spacing / spacing)^2 for a difference d of neighbours, 0 beside what is not
/// finite; a pull of so many mean conductances of a voxel's edges.
void set_edges(RandomWalker& walker, const std::array<double, 3>& spacing_mm, std::span<const float> image,
               std::span<const std::uint8_t> finite, double beta, double pull, const RunJobs& run);

}  // namespace simplexseg
