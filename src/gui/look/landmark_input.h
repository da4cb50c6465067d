// SPDX-License-Identifier: Apache-2.0
// Landmarks that the user places in slices to start a registration.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace simplexseg {

/// Corresponding points of the volume and a layer, mm.
struct LandmarkPair {
  Eigen::Vector3d volume_mm{0, 0, 0}, layer_mm{0, 0, 0};
  Eigen::Vector3d shown_mm{0, 0, 0};  ///< place in the slices at which the layer showed its point
};

/// Pairs that are placed, and the point that the next click places. Volume: slices show the volume alone; Layer: the
/// layer alone.
struct LandmarkInput {
  enum class Next : std::uint8_t { None, Volume, Layer };
  Next next = Next::None;
  std::uint32_t layer = 0;
  Eigen::Vector3d volume_mm{0, 0, 0};  ///< first point of the next pair, for Layer
  std::vector<LandmarkPair> pairs;
};

}  // namespace simplexseg
