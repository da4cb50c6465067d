// SPDX-License-Identifier: Apache-2.0
// Measures of all cells that MarkView and UpdateView need.
#pragma once
#include <array>
#include <vector>

#include "core/vec3.h"
#include "field/evidence_settings.h"
#include "field/geodesic_distance.h"
#include "field/mark_view.h"

namespace simplexseg {

/// Noise of neighbours within the inside marks, from fetch_inner_difference() (parallel/inner_difference.h).
inline float noise_of(float inner_difference) { return inner_difference + 0.01f; }

/// Ways on which what the image changes counts, and ways on which edges count: what is far above the noise.
inline EdgeCost cost_of_changes(const EvidenceSettings& settings) {
  return {static_cast<float>(settings.length_cost), 0};
}
inline EdgeCost cost_of_edges(float noise) { return {0.002f, 3 * noise}; }

/// Where ways to the marks start: 0 there, far elsewhere. `open`: is_open() of the cell.
SIMPLEXSEG_HD bool is_inside_start(Constraint known) { return known == Constraint::Inside; }
SIMPLEXSEG_HD bool is_outside_start(Constraint known, bool open) {
  return known != Constraint::Inside && known != Constraint::None && !open;
}
SIMPLEXSEG_HD float start_of_way(bool start) { return start ? 0.0f : 1e4f; }

/// From the values in the inside marks, which are reordered: of the image, and of it smoothed twice. What has none,
/// as later marks have taken all of them, stays as it is.
Strangeness strangeness_among(std::array<std::vector<float>, 3>& values);

}  // namespace simplexseg
