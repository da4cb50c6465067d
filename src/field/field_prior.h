// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "field/box_grid.h"
#include "field/evidence_settings.h"
#include "field/mark_classifier.h"
#include "field/mark_view.h"
#include "field/marked_voxels.h"
#include "field/run_jobs.h"
#include "field/update_view.h"

namespace simplexseg {

/// Balls of the marks, in their order, the inside ball of a boundary mark first. `geometry`: grid of the box.
std::vector<MarkedBall> marked_balls(std::span<const Mark> marks, const VolumeGeometry& geometry);

/// Training samples of the appearance classifier; either list may be empty.
struct AppearanceSamples {
  std::vector<ClassifierSample> inside, outside;
};
AppearanceSamples appearance_samples(std::span<const Constraint> constraints, const EvidenceSettings& settings);

/// Whether a cell of a side of the box may belong to the object by its appearance score.
SIMPLEXSEG_HD bool is_open(Constraint constraint, float score, float open_side) {
  return constraint == Constraint::FarBorder && score > open_side;
}

/// Bin of a cell for expected_dice_odds_factor(): its probability, 255 in inside marks; -1 (ignored) outside.
SIMPLEXSEG_HD int threshold_bin(Constraint constraint, std::uint8_t probability) {
  return constraint == Constraint::None ? probability : constraint == Constraint::Inside ? 255 : -1;
}
/// Factor on the odds that moves the expected-Dice threshold to 0.5. If each cell is foreground with its probability
/// independently, the threshold is half of the largest expected Dice; it is bounded to 0.2 .. 0.5. `count`: number of
/// cells in each threshold_bin(). Source: docs/mathematics.md 8.4.
double expected_dice_odds_factor(std::span<const int, 256> count);
/// Probability, 0..255 for 0..1, with its odds multiplied by a factor.
SIMPLEXSEG_HD std::uint8_t scaled_odds(int probability, double factor) {
  return static_cast<std::uint8_t>(255 * (probability * factor / (probability * factor + 255 - probability)) + 0.5);
}

inline constexpr double kWalkerTolerance = 0.01;  ///< of the random walker of the marks alone

}  // namespace simplexseg
