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

/// A ball of a mark that was made since the field before; a boundary mark has two.
struct FreshMark {
  std::vector<float> square_mm;  ///< of the distance of each voxel to its centre
  float radius_mm;
  bool inside;     ///< else outside
  float look;      ///< of the image at its centre
  float depth_mm;  ///< from its centre to the nearest voxel on the other side of the field before
  int voxel;       ///< nearest to its centre
};

/// Ball of an inside or outside mark; a boundary mark has two.
struct MarkedBall {
  std::array<float, 3> index;  ///< of its centre, in the box
  float radius_mm;
  bool inside;  ///< else outside
};

/// What the prior is made from.
struct PriorInput {
  const BoxGrid& grid;
  const std::array<double, 3>& spacing_mm;
  std::span<const float> image;  ///< smoothed
  const FeatureLists& features;
  std::span<const Known> known;
  std::span<const float> from_inside;    ///< mm to the nearest centre of an inside or boundary mark, squared
  std::span<const std::uint8_t> before;  ///< field before the fresh marks, 1..255 for 0..1, 0: not known; or empty
  double reach_mm;                       ///< of the largest inside mark (seed_reach.h): the object's scale
  double radius_mm;                      ///< of the largest inside mark
  float inner_difference;                ///< conductances.h
  std::span<const MarkedBall> balls;     ///< of all marks
  std::span<const FreshMark> fresh;      ///< empty where nothing is known of a field before
};

inline constexpr int kMiddleBefore = 127;  ///< what is above is the object of the field before

/// What the voxels of the marks look like.
struct Looks {
  std::vector<float> score;  ///< about -1 .. 1: how much more a voxel looks like inside marks than like outside ones
  std::vector<std::uint8_t> open;  ///< 1: a voxel of the box's sides that may be the object's
};
Looks looks_of(const PriorInput& input, const EvidenceSettings& settings, const RunJobs& run);

/// P(object) of every voxel, 0..255 for 0..1: what a learned network says of MarkFeatures, `walk` being P(object) by
/// the random walker of the marks alone; where there are fresh marks, what another says of that, of the field before
/// and of UpdateFeatures.
std::vector<std::uint8_t> field_prior(const PriorInput& input, const Looks& looks, std::span<const float> walk,
                                      const EvidenceSettings& settings, const RunJobs& run);

}  // namespace simplexseg
