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

/// In the order of the marks, a boundary mark's inside ball first; `geometry`: of the box.
std::vector<MarkedBall> marked_balls(std::span<const Mark> marks, const VolumeGeometry& geometry);

/// What the classifier of looks learns from; either list may be empty.
struct LookSamples {
  std::vector<ClassifierSample> inside, outside;
};
LookSamples look_samples(std::span<const Constraint> known, const EvidenceSettings& settings);

SIMPLEXSEG_HD bool is_open(Constraint known, float score, float open_side) {
  return known == Constraint::FarBorder && score > open_side;
}

/// What a voxel counts as where the best cut is looked for, or -1: those that are known outside are not asked.
SIMPLEXSEG_HD int counted_for_cut(Constraint known, std::uint8_t probability) {
  return known == Constraint::None ? probability : known == Constraint::Inside ? 255 : -1;
}
/// What odds are to be raised by so that the middle is where the Dice of what is above it is the largest to be
/// expected, each voxel being the object's with its probability: at half that Dice. `count`: of each counted_for_cut().
double raise_to_best_cut(std::span<const int, 256> count);
SIMPLEXSEG_HD std::uint8_t moved_by(int probability, double raise) {
  return static_cast<std::uint8_t>(255 * (probability * raise / (probability * raise + 255 - probability)) + 0.5);
}

inline constexpr double kWalkerTolerance = 0.01;  ///< of the walk of the marks alone: it is one voice of several

}  // namespace simplexseg
