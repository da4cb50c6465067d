// SPDX-License-Identifier: Apache-2.0
// Formulas of the narrow band around the surface for one cell (parallel/surface.h).
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "core/quantile.h"
#include "core/vec3.h"
#include "field/evidence_settings.h"
#include "image/distance_map.h"

namespace simplexseg {

/// Error of the previous surface at a new mark.
struct SurfaceShift {
  float at_mm[3];        ///< position of the mark along the axes of the box, from its first voxel
  float outward_voxels;  ///< outward shift of the surface there
  float error_depth_mm;  ///< > 0: depth of the mark in a large error, around which the previous surface has no weight
};

/// Terms of the narrow band that are computed from the marks.
struct BandTerms {
  double offset_log_odds = 0;        ///< added to the whole band (docs/adr/0026-band-offset-from-marks.md)
  double temporal_weight = 0;        ///< log odds per voxel inside the shifted previous surface
  std::vector<SurfaceShift> shifts;  ///< of the previous surface, by the new marks

  /// Whether the previous surface contributes.
  bool has_temporal_term() const { return temporal_weight > 0 || !shifts.empty(); }
};

}  // namespace simplexseg

namespace simplexseg::surface {

inline constexpr int kPasses = 2;
inline constexpr float kMostLogOdds = 3;             // bound of the appearance log odds before smoothing
inline constexpr float kAppearanceWeight = 2;        // factor of the appearance log odds
inline constexpr double kAppearanceSmoothing = 0.7;  // Gaussian of the appearance log odds, voxels
inline constexpr double kAgreementScale = 4;         // Gaussian of the agreement around a voxel, voxels
// Share of the band around a voxel where the sign of the appearance log odds agrees with the object: the weight of
// appearance is 0 below the first value and 1 above the second. Random signs agree in one half.
inline constexpr float kLeastAgreement = 0.75f, kFullAgreement = 0.9f;
// Share of the marked voxels in the band that agree. A low one shows that the object does not end where appearance
// changes. kUnmarkedVoxels are added as agreeing ones.
inline constexpr float kLeastMarkAgreement = 0.8f, kFullMarkAgreement = 0.9f, kUnmarkedVoxels = 60;
inline constexpr float kLeastWeight = 1e-3f;       // added to weights of windows
inline constexpr float kLeastProbability = 0.02f;  // bound of the probability in its logit
inline constexpr float kMostTemporalDistance = 2;  // bound of the distance to the previous surface, voxels
inline constexpr float kMostShift = 4;             // bound of the shift by all new marks, voxels
inline constexpr float kDeepMarkDepths = 3;        // Gaussian around a mark deep in an error, its depths
inline constexpr int kMostNoiseSamples = 100000;
inline constexpr float kLeastNoise = 1e-3f;
/// Standard deviation of noise, from the median absolute difference of neighbours.
SIMPLEXSEG_HD float noise_of_median(float difference) {
  constexpr auto deviations = static_cast<float>(kDeviationsOfMedian / std::numbers::sqrt2);
  return deviations * difference + kLeastNoise;
}

/// Bounds x to least .. most.
SIMPLEXSEG_HD float within(float x, float least, float most) { return smaller(larger(x, least), most); }

/// Appearance log odds of a voxel: log likelihood ratio of its intensity under local normal distributions in the object
/// and outside, bounded. Weights, values and squares are summed in a Gaussian window, over the object and over both
/// sides. `noise_variance`: added to both variances.
SIMPLEXSEG_HD float appearance_log_odds(float value, float in_weight, float in_value, float in_square, float all_weight,
                                        float all_value, float all_square, float noise_variance) {
  const float inner = in_weight + kLeastWeight;
  const float outer = larger(0.0f, all_weight - in_weight) + kLeastWeight;
  const float mean_in = in_value / inner, mean_out = (all_value - in_value) / outer;
  const float variance_in = larger(0.0f, in_square / inner - mean_in * mean_in);
  const float variance_out = larger(0.0f, (all_square - in_square) / outer - mean_out * mean_out);
  const float to_in = value - mean_in, to_out = value - mean_out;
  const float log_odds = (to_out * to_out - to_in * to_in) / (variance_in + variance_out + 2 * noise_variance);
  return within(log_odds, -kMostLogOdds, kMostLogOdds);
}

/// Weight of appearance, 0 to 1, from a share of agreement.
SIMPLEXSEG_HD float agreement_weight(float agreement, float least, float full) {
  return within((agreement - least) / (full - least), 0.0f, 1.0f);
}

/// Weight of appearance, 0 to 1, from the band around a voxel: sums over the band on each side, and over its cells that
/// agree.
SIMPLEXSEG_HD float local_weight(float in_band, float in_agreed, float out_band, float out_agreed) {
  constexpr float least = 0.1f * kLeastWeight;
  const float share = (in_agreed / (in_band + least) + out_agreed / (out_band + least)) / 2;
  return agreement_weight(share, kLeastAgreement, kFullAgreement);
}

/// Log odds of a voxel of the band. `field`, `faired`: its probability before and after fairing; `appearance`: smoothed
/// appearance log odds, `weight`: their weight; `terms`: sum of the offset and TemporalTerm.
SIMPLEXSEG_HD float band_log_odds(float field, float faired, float appearance, float weight, float terms) {
  const float blended = faired + weight * (field - faired);
  const float p = within(blended, kLeastProbability, 1 - kLeastProbability);
  return std::log(p / (1 - p)) + kAppearanceWeight * weight * appearance + terms;
}

SIMPLEXSEG_HD float probability_of(float log_odds) { return 1 / (1 + std::exp(-log_odds)); }

/// Temporal (previous-surface) term of the log odds of a voxel: its distance to the previous surface, shifted by the
/// new marks with a Gaussian of the distance to them. Source: docs/mathematics.md 8.7.
struct TemporalTerm {
  int first[3], size[3];  ///< of the part of the box
  float mm[3];            ///< spacing
  const SurfaceShift* shifts;
  int count;            ///< number of shifts
  float per_square_mm;  ///< 1 / (2 EvidenceSettings::shift_scale^2)
  float voxel_mm, weight, shift_weight;
  const std::uint8_t* object;  ///< previous object in the part; null: there is none, and the term is 0
  const float* distance;       ///< distance to the previous surface, mm

  /// Log odds of voxel v. `appearance_weight`: the previous surface has the remaining weight.
  SIMPLEXSEG_HD float operator()(int v, float appearance_weight) const {
    if (object == nullptr) return 0;
    const int at[3]{v % size[0], v / size[0] % size[1], v / (size[0] * size[1])};
    float outward = 0, previous_weight = weight * (1 - appearance_weight);
    for (int m = 0; m < count; ++m) {
      const SurfaceShift& shift = shifts[m];
      float square = 0;
      for (int a = 0; a < 3; ++a) {
        const float offset = static_cast<float>(at[a] + first[a]) * mm[a] - shift.at_mm[a];
        square += offset * offset;
      }
      if (shift.error_depth_mm > 0) {
        const float scale = kDeepMarkDepths * shift.error_depth_mm;
        previous_weight *= 1 - std::exp(-square / (2 * scale * scale));
      } else {
        outward += shift.outward_voxels * std::exp(-square * per_square_mm);
      }
    }
    outward = within(outward, -kMostShift, kMostShift);
    const float inside = (object[v] ? distance[v] : -distance[v]) / voxel_mm;
    return previous_weight * within(inside + outward, -kMostTemporalDistance, kMostTemporalDistance) +
           shift_weight * outward;
  }
};

/// Temporal term for a part of the box, without its pointers.
inline TemporalTerm temporal_term(const BandTerms& terms, const VoxelBox& part, const std::array<double, 3>& spacing_mm,
                                  const EvidenceSettings& settings) {
  TemporalTerm term{};
  for (int a = 0; a < 3; ++a) {
    term.first[a] = part.first[a], term.size[a] = part.size[a];
    term.mm[a] = static_cast<float>(spacing_mm[a]);
  }
  term.voxel_mm = std::min({term.mm[0], term.mm[1], term.mm[2]});
  const auto scale_mm = static_cast<float>(settings.shift_scale) * term.voxel_mm;
  term.per_square_mm = 1 / (2 * scale_mm * scale_mm);
  term.count = static_cast<int>(terms.shifts.size());
  term.weight = static_cast<float>(terms.temporal_weight);
  term.shift_weight = static_cast<float>(settings.shift_weight);
  return term;
}

}  // namespace simplexseg::surface
