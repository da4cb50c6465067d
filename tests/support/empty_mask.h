// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "image/mask.h"

namespace simplexseg {

/// Mask without any voxel of the object.
inline Mask empty_mask(const std::array<int, 3>& size, const Eigen::Vector3d& spacing_mm = {1, 1, 1}) {
  VolumeGeometry geometry;
  geometry.size = size;
  geometry.spacing_mm = spacing_mm;
  return {geometry, std::vector<std::uint8_t>(geometry.voxel_count())};
}

}  // namespace simplexseg
