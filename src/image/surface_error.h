// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "image/distance_map.h"
#include "image/mask.h"

namespace simplexseg {

struct Mask;

/// Distances of the vertices of a mesh from a reference surface, fast enough to be evaluated every few steps of a run.
/// Uses a distance map that is computed once, on the bounding box of the reference enlarged on each side by a quarter
/// of its size and two voxels. One-sided: parts of the reference that are far from all vertices do not count. For the
/// agreement of two solids use compare() (image/metrics.h).
class SurfaceError {
 public:
  struct Values {
    double mean_mm, p95_mm, max_mm;
  };

  explicit SurfaceError(const Mask& reference);
  /// Distance (mm) of a position (mm, LPS), interpolated linearly between voxel centres. Outside the map, an upper
  /// bound: the distance at the nearest point of the map plus the distance to that point. Infinite for an empty
  /// reference and for a position that is not finite.
  double at(const Eigen::Vector3d& position_mm) const;
  /// Statistics of the distances of the positions (mm, LPS); all 0 without positions.
  Values of(std::span<const Eigen::Vector3f> positions_mm) const;

 private:
  VoxelBox box_{};
  Eigen::Affine3d index_from_world_, world_from_index_;  ///< transforms between world (mm) and indices of the box
  std::vector<float> signed_mm_;                         ///< distances, negative inside; empty for an empty reference
};

}  // namespace simplexseg
