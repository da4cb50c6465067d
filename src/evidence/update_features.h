// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "evidence/field_prior.h"
#include "evidence/prior_network.h"
#include "evidence/update_view.h"

namespace simplexseg {

/// What the newest marks change, by numbers without unit that mean the same in all images and for objects of all sizes.
/// Seen from the nearest of them, so that inside and outside are the same thing: the network answers how likely a voxel
/// is on that mark's side.
class UpdateFeatures {
 public:
  static constexpr int kCount = 12;

  /// `anew`: the prior as if there had been no field before, 0..255. There must be fresh marks. `input` and `anew` must
  /// outlive the object.
  UpdateFeatures(const PriorInput& input, std::span<const std::uint8_t> anew, const EvidenceSettings& settings,
                 const RunJobs& run);
  UpdateFeatures(const UpdateFeatures&) = delete;
  void fill(int first, int count, FeatureRows& to) const;
  const UpdateView& view() const { return view_; }

 private:
  std::vector<std::uint16_t> nearest_;  ///< of the fresh marks
  std::vector<float> square_, edges_;   ///< mm^2 to it; edges between
  std::vector<float> inward_;           ///< mm from the surface of the field before, above 0 inside
  std::vector<NewMarkVoxel> balls_;
  UpdateView view_{};
};

}  // namespace simplexseg
