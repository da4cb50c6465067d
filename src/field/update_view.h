// SPDX-License-Identifier: Apache-2.0
// Features of the network of new marks.
#pragma once
#include <cmath>
#include <cstdint>

#include "core/vec3.h"

namespace simplexseg {

/// Ball of a mark that was made since the field before; a boundary mark has two.
struct NewMarkVoxel {
  float radius_mm;
  float look;      ///< of the image at its centre
  float depth_mm;  ///< from its centre to the nearest voxel on the other side of the field before
  int voxel;       ///< nearest to its centre
  bool inside;     ///< else outside
};

inline constexpr int kPreviousThreshold = 127;  ///< what is above is the object of the field before

/// mm from the surface of the field before, above 0 inside, from the distance to the nearest voxel on the other side:
/// the surface lies half way between voxels.
SIMPLEXSEG_HD float inward_mm(float to_other_mm, bool inside, float least_mm) {
  const float half = 0.5f * least_mm;
  return (smaller(to_other_mm, 1e6f) - half) * (inside ? 1.0f : -1.0f);
}

/// Features of a cell that new marks give, seen from the nearest of them, so that inside and outside are the same: the
/// network gives the probability that the cell is on the side of that mark.
struct UpdateView {
  static constexpr int kFeatures = 12;
  const float* image;                           ///< smoothed
  const std::uint8_t *before, *prior_of_marks;  ///< field before the fresh marks; the prior as if there had been none
  const NewMarkVoxel* fresh;
  const std::uint16_t* nearest;  ///< of the fresh marks
  const float *square, *edges;   ///< mm^2 to it; edges between
  const float* inward;           ///< inward_mm()
  float per_radius, least_mm, per_noise, marks;
  float far_memory, far_depths;  ///< EvidenceSettings

  SIMPLEXSEG_HD float depth_of(int v) const { return fresh[nearest[v]].depth_mm + 0.5f * least_mm; }

  /// Calls set(f, value) for each feature f of a voxel.
  template <class Set>
  SIMPLEXSEG_HD void fill(int v, const Set& set) const {
    const NewMarkVoxel& mark = fresh[nearest[v]];
    const float depth = depth_of(v), side = mark.inside ? 1.0f : -1.0f;
    const float p = (prior_of_marks[v] + 0.5f) / 256, away = side * inward[v];
    const float was = before[v] == 0 ? -1.0f : (before[v] - 128) / 127.0f;
    const float distance = std::sqrt(square[v]);
    const float across = away / depth;  // of the mark itself about -1
    const float along = std::sqrt(larger(square[v] / (depth * depth) - (across + 1) * (across + 1), 0.0f));
    set(0, side * std::log(p / (1 - p)));
    set(1, side * was);
    set(2, smaller(larger(across, -8.0f), 8.0f));
    set(3, std::log(distance / depth + 0.2f));
    set(4, std::log(distance * per_radius + 0.05f));
    set(5, std::log(edges[v] + 0.05f));
    set(6, smaller(std::fabs(image[v] - mark.look) * per_noise, 5.0f));
    set(7, std::log(depth * per_radius));
    set(8, std::log(along + 0.3f));
    set(9, std::log(depth / least_mm));
    set(10, std::log(marks));
    set(11, smaller(larger(away / least_mm, -8.0f), 8.0f));
  }

  /// Whether the nearest of the new marks of a voxel is an inside one.
  SIMPLEXSEG_HD bool nearest_is_inside(int v) const { return fresh[nearest[v]].inside; }
  /// The prior of a voxel, `same_side` being how likely it is on its nearest new mark's side: far from that the field
  /// before is heard.
  SIMPLEXSEG_HD std::uint8_t with_memory(int v, std::uint8_t same_side) const {
    const float now = nearest_is_inside(v) ? same_side : 255.0f - same_side;
    const float depths_away = std::sqrt(square[v]) / depth_of(v);
    const float old = before[v] == 0 ? 0.0f : far_memory * smaller(larger(depths_away / far_depths - 1, 0.0f), 1.0f);
    return static_cast<std::uint8_t>(now + old * (before[v] - now) + 0.5f);
  }
};

}  // namespace simplexseg
