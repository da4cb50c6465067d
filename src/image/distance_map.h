// SPDX-License-Identifier: Apache-2.0
// Exact Euclidean distances between sets of voxels.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace simplexseg {

/// Part of a grid, which may reach beyond it: all that distances depend on. i fastest.
struct VoxelBox {
  std::array<int, 3> first, size;
  std::size_t offset(int i, int j, int k) const { return (static_cast<std::size_t>(k) * size[1] + j) * size[0] + i; }
  std::size_t voxel_count() const { return static_cast<std::size_t>(size[0]) * size[1] * size[2]; }
  /// Whether it has voxels, all of them in a grid of this size.
  bool lies_in(const std::array<int, 3>& grid) const {
    bool in = true;
    for (int a = 0; a < 3; ++a) in = in && first[a] >= 0 && size[a] > 0 && first[a] <= grid[a] - size[a];
    return in;
  }
  bool operator==(const VoxelBox&) const = default;
};

/// Distance (mm, between voxel centres) from each voxel set in `from` to the nearest one set in `to`, in no stated
/// order; infinite when none is. Both have a byte for each voxel of the box. `mm_from_index` may be any invertible
/// matrix. Source: Felzenszwalb and Huttenlocher 2012, Distance Transforms of Sampled Functions; a k-d tree where the
/// axes are not orthogonal.
std::vector<double> distances_between(const std::vector<std::uint8_t>& from, const std::vector<std::uint8_t>& to,
                                      const VoxelBox& box, const Eigen::Matrix3d& mm_from_index);
/// The same from every voxel of the box, in the box's order.
std::vector<float> distance_map(const std::vector<std::uint8_t>& to, const VoxelBox& box,
                                const Eigen::Matrix3d& mm_from_index);

/// Whether axes are orthogonal to the precision of headers: to 6 or 7 digits.
bool are_orthogonal(const Eigen::Matrix3d& mm_from_index);

struct DistanceSummary {
  double max, percentile95, mean;
};
/// Reorders `distances`, which must not be empty. The percentile interpolates linearly between order statistics.
DistanceSummary summarise(std::vector<double>& distances);

}  // namespace simplexseg
