// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "evidence/field_prior.h"
#include "evidence/prior_network.h"

namespace simplexseg {

/// What all marks together say of a voxel, by numbers without unit that mean the same in all images and for objects of
/// all sizes: how alike it looks, ways to the marks, distances in scales of the object, what lies on the straight line
/// to the nearest inside mark. The network answers how likely a voxel is the object's.
class MarkFeatures {
 public:
  static constexpr int kCount = 21;

  /// `walk`: P(object) by the random walker of the marks alone. There must be an inside mark. All that is given must
  /// outlive the object.
  MarkFeatures(const PriorInput& input, const Looks& looks, std::span<const float> walk,
               const EvidenceSettings& settings, const RunJobs& run);
  MarkFeatures(const MarkFeatures&) = delete;
  void fill(int first, int count, FeatureRows& to) const;

 private:
  void measure_ways(const EvidenceSettings& settings, const RunJobs& run);
  void measure_inside();
  void measure_wall();
  void find_nearest(const RunJobs& run);

  const PriorInput& input_;
  const Looks& looks_;
  std::vector<float> inside_, outside_;      ///< geodesic distance to the marks
  std::vector<float> edges_in_, edges_out_;  ///< edges passed on the way to them
  std::vector<std::uint16_t> nearest_;       ///< of the balls of inside marks
  std::vector<float> from_outside_;          ///< mm to the nearest centre of an outside mark, squared
  MarkView view_{};
};

}  // namespace simplexseg
