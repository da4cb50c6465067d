// SPDX-License-Identifier: Apache-2.0
// Formulas of the narrow band around the surface for one cell (parallel/surface.h).
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "core/vec3.h"
#include "field/evidence_settings.h"
#include "field/quantile.h"
#include "image/distance_map.h"

namespace simplexseg {

/// What a new mark says of where the surface was in the field before.
struct SurfaceMove {
  float at_mm[3];    ///< the mark, along the box's axes from its first voxel
  float out_voxels;  ///< the surface is so much further out there
  float deep_mm;     ///< above 0: the mark lies so deep in what was wrong, a leak, say: nothing holds around it
};

/// Terms of the narrow band that are computed from the marks.
struct BandTerms {
  double offset_log_odds = 0;      ///< added to the whole band (docs/adr/0026-band-offset-from-marks.md)
  double temporal_weight = 0;      ///< log odds per voxel inward of the previous surface, as moved by `moves`
  std::vector<SurfaceMove> moves;  ///< from there, by the marks made since

  /// Whether the previous surface contributes.
  bool has_temporal_term() const { return temporal_weight > 0 || !moves.empty(); }
};

}  // namespace simplexseg

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
inline constexpr float kLeastMarkAgreement = 0.8f, kFullMarkAgreement = 0.9f, kUnmarkedVoxels = 60;
inline constexpr float kLeastWeight = 1e-3f;       // of a neighbourhood's voxels together
inline constexpr float kLeastProbability = 0.02f;  // of what the field says
inline constexpr float kMostHeld = 2;              // voxels from where the surface was
inline constexpr float kMostMoved = 4;             // voxels, by all new marks together
inline constexpr float kDepthsForgotten = 3;       // Gaussian around a mark that lies deep in what was wrong
inline constexpr int kMostNoiseSamples = 100000;
inline constexpr float kLeastNoise = 1e-3f;
/// Standard deviation of the noise of which neighbours have this median difference.
SIMPLEXSEG_HD float noise_of_median(float difference) {
  constexpr auto deviations = static_cast<float>(kDeviationsOfMedian / std::numbers::sqrt2);
  return deviations * difference + kLeastNoise;
}

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

/// Log odds of a voxel of the layer, by the field, the even field, what it looks like, and what marks say of the
/// surface: its lean, and HeldSurface.
SIMPLEXSEG_HD float odds(float field, float even, float look, float trust, float said) {
  const float said_here = even + trust * (field - even);
  const float p = within(said_here, kLeastProbability, 1 - kLeastProbability);
  return std::log(p / (1 - p)) + kWeightOfLook * trust * look + said;
}

SIMPLEXSEG_HD float probability_of(float odds) { return 1 / (1 + std::exp(-odds)); }

/// Log odds that a voxel has from where the surface of the field before was and from how new marks move it: each of
/// them by what it found to be wrong, and what is beside it by a Gaussian of the distance, as kriging would.
struct HeldSurface {
  int first[3], size[3];  ///< of the part of the box
  float mm[3];            ///< spacing
  const SurfaceMove* moves;
  int count;            ///< of them
  float per_square_mm;  ///< 1 / 2 Gaussian^2
  float voxel_mm, hold, pull;
  const std::uint8_t* object;  ///< of the field before, in the part; null: there is none, and all is 0
  const float* distance;       ///< mm, to its surface

  /// `trust`: how far looks are believed there; they then say where the surface is, not where it was.
  SIMPLEXSEG_HD float operator()(int v, float trust) const {
    if (object == nullptr) return 0;
    const int at[3]{v % size[0], v / size[0] % size[1], v / (size[0] * size[1])};
    float out = 0, held = hold * (1 - trust);
    for (int m = 0; m < count; ++m) {
      const SurfaceMove& move = moves[m];
      float square = 0;
      for (int a = 0; a < 3; ++a) {
        const float way = static_cast<float>(at[a] + first[a]) * mm[a] - move.at_mm[a];
        square += way * way;
      }
      if (move.deep_mm > 0) {
        const float scale = kDepthsForgotten * move.deep_mm;
        held *= 1 - std::exp(-square / (2 * scale * scale));
      } else {
        out += move.out_voxels * std::exp(-square * per_square_mm);
      }
    }
    out = within(out, -kMostMoved, kMostMoved);
    const float inward = (object[v] ? distance[v] : -distance[v]) / voxel_mm;
    return held * within(inward + out, -kMostHeld, kMostHeld) + pull * out;
  }
};

/// Of a part of the box: all but what is in the memory of the processor.
inline HeldSurface held_surface(const BandTerms& said, const VoxelBox& part, const std::array<double, 3>& spacing_mm,
                                const EvidenceSettings& settings) {
  HeldSurface held{};
  for (int a = 0; a < 3; ++a) {
    held.first[a] = part.first[a], held.size[a] = part.size[a];
    held.mm[a] = static_cast<float>(spacing_mm[a]);
  }
  held.voxel_mm = std::min({held.mm[0], held.mm[1], held.mm[2]});
  const auto reach_mm = static_cast<float>(settings.surface_reach) * held.voxel_mm;
  held.per_square_mm = 1 / (2 * reach_mm * reach_mm);
  held.count = static_cast<int>(said.moves.size());
  held.hold = static_cast<float>(said.temporal_weight), held.pull = static_cast<float>(settings.surface_pull);
  return held;
}

}  // namespace simplexseg::surface
