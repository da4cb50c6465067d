// SPDX-License-Identifier: Apache-2.0
// What settle_surface() works out for one voxel, in both of its versions (surface_layer.h, parallel/surface.h).
#pragma once
#include <cmath>

#include "core/vec3.h"

namespace simplexseg::surface {

inline constexpr int kPasses = 2;
inline constexpr float kMostLogOdds = 3;       // of one voxel's look
inline constexpr float kWeightOfLook = 2;      // beside the field's log odds
inline constexpr double kLookSmoothing = 0.7;  // voxels
inline constexpr double kAgreementScale = 4;   // voxels
// Looks that do not agree with the field about most of the layer are not believed around there: agreement below the
// first counts as none, above the second as whole; one half is chance.
inline constexpr float kLeastAgreement = 0.75f, kFullAgreement = 0.9f;
// The same for what marks say, which is true: a mark in the layer that looks like the other side tells that this object
// does not end where looks change. What is not marked yet counts as so many voxels of whole agreement.
inline constexpr float kLeastMarkAgreement = 0.7f, kFullMarkAgreement = 0.85f, kUnmarkedVoxels = 30;
inline constexpr float kLeastWeight = 1e-3f;       // of a neighbourhood's voxels together
inline constexpr float kLeastProbability = 0.02f;  // of what the field says
inline constexpr int kMostNoiseSamples = 100000;
inline constexpr float kLeastNoise = 1e-3f;

/// x between two bounds.
SIMPLEXSEG_HD float within(float x, float least, float most) { return smaller(larger(x, least), most); }

/// Log odds that a voxel looks like the object around there, not like the rest: sums of weights, values and squares in
/// a Gaussian around it, of the object and of both.
SIMPLEXSEG_HD float look(float value, float in_weight, float in_value, float in_square, float all_weight,
                         float all_value, float all_square, float least_variance) {
  const float inner = in_weight + kLeastWeight;
  const float outer = larger(0.0f, all_weight - in_weight) + kLeastWeight;
  const float mean_in = in_value / inner, mean_out = (all_value - in_value) / outer;
  const float variance_in = larger(0.0f, in_square / inner - mean_in * mean_in);
  const float variance_out = larger(0.0f, (all_square - in_square) / outer - mean_out * mean_out);
  const float to_in = value - mean_in, to_out = value - mean_out;
  const float log_odds = (to_out * to_out - to_in * to_in) / (variance_in + variance_out + 2 * least_variance);
  return within(log_odds, -kMostLogOdds, kMostLogOdds);
}

SIMPLEXSEG_HD float weight_of(float agreement, float least, float full) {
  return within((agreement - least) / (full - least), 0.0f, 1.0f);
}

/// How far looks are believed around a voxel: of the layer on either side, and what of it looks like that side.
SIMPLEXSEG_HD float trust(float in_layer, float in_agreed, float out_layer, float out_agreed) {
  constexpr float least = 0.1f * kLeastWeight;
  const float share = (in_agreed / (in_layer + least) + out_agreed / (out_layer + least)) / 2;
  return weight_of(share, kLeastAgreement, kFullAgreement);
}

/// Log odds of a voxel of the layer, by the field, the even field, what it looks like, and the lean of all.
SIMPLEXSEG_HD float odds(float field, float even, float look, float trust, float lean) {
  const float said_here = even + trust * (field - even);
  const float p = within(said_here, kLeastProbability, 1 - kLeastProbability);
  return std::log(p / (1 - p)) + kWeightOfLook * trust * look + lean;
}

SIMPLEXSEG_HD float probability_of(float odds) { return 1 / (1 + std::exp(-odds)); }

}  // namespace simplexseg::surface
