// SPDX-License-Identifier: Apache-2.0
// Noise, edge costs and z-scores for the features of MarkView and UpdateView.
#pragma once
#include <array>
#include <vector>

#include "core/vec3.h"
#include "field/evidence_settings.h"
#include "field/geodesic_distance.h"
#include "field/mark_view.h"

namespace simplexseg {

/// Noise within the inside marks, intensity, from fetch_inner_difference() (parallel/inner_difference.h).
inline float noise_of(float inner_difference) { return inner_difference + 0.01f; }

/// Edge costs by which geodesic distances measure intensity changes, or edges, which are far above the noise.
inline EdgeCost cost_of_changes(const EvidenceSettings& settings) {
  return {static_cast<float>(settings.length_cost), 0};
}
inline EdgeCost cost_of_edges(float noise) { return {0.002f, 3 * noise}; }

/// Sources of the geodesic distances to inside and outside marks. `open`: is_open() of the cell.
SIMPLEXSEG_HD bool is_inside_source(Constraint constraint) { return constraint == Constraint::Inside; }
SIMPLEXSEG_HD bool is_outside_source(Constraint constraint, bool open) {
  return constraint != Constraint::Inside && constraint != Constraint::None && !open;
}
/// Geodesic distance before relaxation.
SIMPLEXSEG_HD float initial_distance(bool is_source) { return is_source ? 0.0f : 1e4f; }

/// Fits z-scores to the values within the inside marks, which are reordered: of the image, and of two smoothed ones.
/// Lists may be empty, since later marks can replace inside marks; their z-scores keep the defaults.
IntensityZScore fit_z_score(std::array<std::vector<float>, 3>& values);

}  // namespace simplexseg
