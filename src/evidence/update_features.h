// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "evidence/field_prior.h"
#include "evidence/prior_network.h"

namespace simplexseg {

/// What the newest marks change, by numbers without unit that mean the same in all images and for objects of all sizes.
/// Seen from the nearest of them, so that inside and outside are the same thing: the network answers how likely a voxel
/// is on that mark's side.
class UpdateFeatures {
 public:
  static constexpr int kCount = 12;

  /// `anew`: the prior as if there had been no field before, 0..255. There must be fresh marks. `input` and `anew` must
  /// outlive the object.
  UpdateFeatures(const PriorInput& input, std::span<const std::uint8_t> anew, const RunJobs& run);
  void fill(int first, int count, FeatureRows& to) const;
  /// Which side the nearest of the new marks of a voxel is on.
  bool nearest_is_inside(int voxel) const { return input_.fresh[nearest_[voxel]].inside; }
  /// How far that is, in its depths.
  float depths_away(int voxel) const { return std::sqrt(square_[voxel]) / depth_of(voxel); }

 private:
  float depth_of(int voxel) const { return input_.fresh[nearest_[voxel]].depth_mm + 0.5f * least_mm_; }

  const PriorInput& input_;
  std::span<const std::uint8_t> anew_;
  std::vector<std::uint16_t> nearest_;  ///< of the fresh marks
  std::vector<float> square_, edges_;   ///< mm^2 to it; edges between
  std::vector<float> inward_;           ///< mm from the surface of the field before, above 0 inside
  float per_radius_, least_mm_, per_noise_, marks_;
};

}  // namespace simplexseg
