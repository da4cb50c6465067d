// SPDX-License-Identifier: Apache-2.0
// Exact Euclidean distances between sets of voxels.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace simplexseg {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Box of voxels of a grid, i fastest. The box may extend beyond the grid. offset() takes indices relative to `first`.
struct VoxelBox {
  std::array<int, 3> first, size;
  std::size_t offset(int i, int j, int k) const { return (static_cast<std::size_t>(k) * size[1] + j) * size[0] + i; }
  std::size_t voxel_count() const { return static_cast<std::size_t>(size[0]) * size[1] * size[2]; }
  /// True if the box is not empty and lies completely inside a grid of this size.
  bool lies_in(const std::array<int, 3>& grid) const {
    bool in = true;
    for (int a = 0; a < 3; ++a) in = in && first[a] >= 0 && size[a] > 0 && first[a] <= grid[a] - size[a];
    return in;
  }
  bool operator==(const VoxelBox&) const = default;
};

/// Distances (mm, between voxel centres) from each set voxel of `from` to the nearest set voxel of `to`, in unspecified
/// order; infinite if `to` is empty. Both masks have one byte for each voxel of the box; `mm_from_index` is any
/// invertible matrix. Method: Felzenszwalb and Huttenlocher 2012, Distance Transforms of Sampled Functions; a k-d tree
/// if the axes are not orthogonal.
std::vector<double> distances_between(const std::vector<std::uint8_t>& from, const std::vector<std::uint8_t>& to,
                                      const VoxelBox& box, const Eigen::Matrix3d& mm_from_index);
/// Distance (mm, between voxel centres) of every voxel of the box to the nearest set voxel of `to`, in the order of the
/// box; infinite if `to` is empty. Distances above `limit_mm` (> 0) are infinite and need less time.
std::vector<float> distance_map(const std::vector<std::uint8_t>& to, const VoxelBox& box,
                                const Eigen::Matrix3d& mm_from_index,
                                double limit_mm = std::numeric_limits<double>::infinity());

/// True if the axes are orthogonal up to cosines of 1e-5, which allows for file headers of 6 or 7 digits.
bool are_orthogonal(const Eigen::Matrix3d& mm_from_index);

struct DistanceSummary {
  double max, percentile95, mean;
};
/// Summarises distances, of which there must be at least one; reorders them. The 95th percentile is interpolated
/// linearly between order statistics.
DistanceSummary summarise(std::vector<double>& distances);

}  // namespace simplexseg
