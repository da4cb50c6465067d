// SPDX-License-Identifier: Apache-2.0
// Features of the network of new marks.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>

#include "core/vec3.h"

namespace simplexseg {

/// NewMarkBall on a grid.
struct NewMarkVoxel {
  float radius_mm;
  float intensity;  ///< smoothed image at its centre
  float depth_mm;   ///< NewMarkBall::depth_mm
  int voxel;        ///< nearest voxel to its centre
  bool inside;      ///< else outside
};

inline constexpr int kPreviousThreshold = 127;  ///< values of the previous field above it belong to its object

/// Signed distance to the previous surface, mm, positive in its object. `to_other_mm`: distance to the nearest voxel on
/// the other side; the surface is assumed half a voxel before that.
SIMPLEXSEG_HD float inward_mm(float to_other_mm, bool inside, float least_spacing_mm) {
  const float half = 0.5f * least_spacing_mm;
  return (smaller(to_other_mm, 1e6f) - half) * (inside ? 1.0f : -1.0f);
}

/// Features of a cell from the new marks, relative to the nearest of them and symmetric in inside and outside: the
/// output of their network is the probability that the cell is on the side of that mark. Source:
/// docs/mathematics.md 8.4.
struct UpdateView {
  /// Features, in the order of the inputs of the network; formulas: docs/mathematics.md 8.4.
  enum Feature {
    kMarksOutput,
    kPreviousField,
    kAcrossInDepths,
    kDistanceInDepths,
    kDistanceInScales,
    kEdges,
    kIntensityDifference,
    kDepthInScales,
    kAlongInDepths,
    kDepthInBlocks,
    kMarkCount,
    kAcrossInBlocks,
    kFeatures
  };
  /// Names of the features, stored with the weights of the network.
  static constexpr std::array<const char*, kFeatures> kFeatureNames = {
      "marks_output",       "previous_field",  "across_in_depths",     "distance_in_depths",
      "distance_in_scales", "edges",           "intensity_difference", "depth_in_scales",
      "along_in_depths",    "depth_in_blocks", "mark_count",           "across_in_blocks"};
  const float* image;                             ///< smoothed
  const std::uint8_t *previous, *prior_of_marks;  ///< previous field, 0 unknown; output of the network of all marks
  const NewMarkVoxel* balls;                      ///< of the new marks
  const std::uint16_t* nearest;                   ///< ball with the nearest centre
  const float *square, *edges;  ///< squared distance to it, mm^2; geodesic distance to new marks by cost_of_edges()
  const float* inward;          ///< inward_mm()
  float per_scale, least_spacing_mm, per_noise, marks;  ///< 1 / object scale, 1 / edge, number of all balls
  float far_memory, far_depths;                         ///< EvidenceSettings

  SIMPLEXSEG_HD float depth_of(int v) const { return balls[nearest[v]].depth_mm + 0.5f * least_spacing_mm; }

  /// Calls set(f, value) for each feature f of a voxel.
  template <class Set>
  SIMPLEXSEG_HD void fill(int v, const Set& set) const {
    const NewMarkVoxel& mark = balls[nearest[v]];
    const float depth = depth_of(v), side = mark.inside ? 1.0f : -1.0f;
    const float p = (prior_of_marks[v] + 0.5f) / 256, away = side * inward[v];
    const float signed_previous = previous[v] == 0 ? -1.0f : (previous[v] - 128) / 127.0f;
    const float distance = std::sqrt(square[v]);
    const float across = away / depth;  // about -1 at the mark
    const float along = std::sqrt(larger(square[v] / (depth * depth) - (across + 1) * (across + 1), 0.0f));
    set(kMarksOutput, side * std::log(p / (1 - p)));
    set(kPreviousField, side * signed_previous);
    set(kAcrossInDepths, smaller(larger(across, -8.0f), 8.0f));
    set(kDistanceInDepths, std::log(distance / depth + 0.2f));
    set(kDistanceInScales, std::log(distance * per_scale + 0.05f));
    set(kEdges, std::log(edges[v] + 0.05f));
    set(kIntensityDifference, smaller(std::fabs(image[v] - mark.intensity) * per_noise, 5.0f));
    set(kDepthInScales, std::log(depth * per_scale));
    set(kAlongInDepths, std::log(along + 0.3f));
    set(kDepthInBlocks, std::log(depth / least_spacing_mm));
    set(kMarkCount, std::log(marks));
    set(kAcrossInBlocks, smaller(larger(away / least_spacing_mm, -8.0f), 8.0f));
  }

  /// Whether the nearest new ball of a voxel is an inside one.
  SIMPLEXSEG_HD bool nearest_is_inside(int v) const { return balls[nearest[v]].inside; }
  /// Prior of a voxel, 0..255 for 0..1, from the output of the network (probability of the side of the nearest new
  /// mark), blended with the previous field far from that mark.
  SIMPLEXSEG_HD std::uint8_t blend_previous(int v, std::uint8_t same_side) const {
    const float now = nearest_is_inside(v) ? same_side : 255.0f - same_side;
    const float depths = std::sqrt(square[v]) / depth_of(v);
    const float share = previous[v] == 0 ? 0.0f : far_memory * smaller(larger(depths / far_depths - 1, 0.0f), 1.0f);
    return static_cast<std::uint8_t>(now + share * (previous[v] - now) + 0.5f);
  }
};

}  // namespace simplexseg
