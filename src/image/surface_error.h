// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "image/distance_map.h"
#include "image/mask.h"

namespace simplexseg {

struct Mask;

/// How far a mesh's vertices lie from the surface of a reference: cheap, for every few steps of a run. The distance map
/// is made once, over the reference's bounding box and a quarter of it around. compare() (image/metrics.h) says how
/// well two solids agree; this says nothing of parts of the reference that no vertex is near.
class SurfaceError {
 public:
  struct Values {
    double mean_mm, p95_mm, max_mm;
  };

  explicit SurfaceError(const Mask& reference);
  /// Distance of one position (mm, LPS), interpolated linearly between voxel centres; beyond the map the distance to
  /// the map is added, so that it is never too small. Infinite for a reference without a voxel, and for a position that
  /// is not finite.
  double at(const Eigen::Vector3d& position_mm) const;
  /// All 0 when there is no position.
  Values of(std::span<const Eigen::Vector3f> positions_mm) const;

 private:
  VoxelBox box_{};
  Eigen::Affine3d index_from_world_, world_from_index_;  ///< the box's
  std::vector<float> signed_mm_;                         ///< < 0 inside; empty: no voxel
};

}  // namespace simplexseg
