// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "evidence/evidence_settings.h"
#include "evidence/mark_classifier.h"
#include "evidence/mark_view.h"
#include "evidence/marked_voxels.h"
#include "evidence/padded_array.h"
#include "evidence/run_jobs.h"
#include "evidence/update_view.h"

namespace simplexseg {

/// A new mark's ball.
struct FreshMark {
  std::vector<float> square_mm;  ///< of the distance of each voxel to its centre
  NewMarkVoxel ball;
};

/// In the order of the marks, a boundary mark's inside ball first; `geometry`: of the box.
std::vector<MarkedBall> marked_balls(std::span<const Mark> marks, const VolumeGeometry& geometry);

/// What the prior is made from.
struct PriorInput {
  const BoxGrid& grid;
  const std::array<double, 3>& spacing_mm;
  std::span<const float> image;  ///< smoothed
  const FeatureLists& features;
  std::span<const Constraint> known;
  std::span<const float> from_inside;    ///< mm to the nearest centre of an inside or boundary mark, squared
  std::span<const std::uint8_t> before;  ///< field before the fresh marks, 1..255 for 0..1, 0: not known; or empty
  double reach_mm;                       ///< of the largest inside mark (seed_reach.h): the object's scale
  double radius_mm;                      ///< of the largest inside mark
  float inner_difference;                ///< conductances.h
  std::span<const MarkedBall> balls;     ///< of all marks
  std::span<const FreshMark> fresh;      ///< empty where nothing is known of a field before
};

/// What the classifier of looks learns from; either list may be empty.
struct LookSamples {
  std::vector<MarkClassifier::Sample> inside, outside;
};
LookSamples look_samples(std::span<const Constraint> known, const EvidenceSettings& settings);

/// What the voxels of the marks look like.
struct Looks {
  std::vector<float> score;  ///< about -1 .. 1: how much more a voxel looks like inside marks than like outside ones
  std::vector<std::uint8_t> open;  ///< 1: a voxel of the box's sides that may be the object's
};
SIMPLEXSEG_HD bool is_open(Constraint known, float score, float open_side) {
  return known == Constraint::FarBorder && score > open_side;
}
Looks looks_of(const PriorInput& input, const EvidenceSettings& settings, const RunJobs& run);

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

inline constexpr double kWalkTolerance = 0.01;  ///< of the walk of the marks alone: it is one voice of several

/// P(object) of every voxel, 0..255 for 0..1: what a learned network says of MarkFeatures, `walk` being P(object) by
/// the random walker of the marks alone; where there are fresh marks, what another says of that, of the field before
/// and of UpdateFeatures.
std::vector<std::uint8_t> field_prior(const PriorInput& input, const Looks& looks, std::span<const float> walk,
                                      const EvidenceSettings& settings, const RunJobs& run);

}  // namespace simplexseg
