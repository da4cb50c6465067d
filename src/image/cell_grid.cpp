// SPDX-License-Identifier: Apache-2.0
#include "image/cell_grid.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/expect.h"

namespace simplexseg {
namespace {

constexpr double kRounding = 1e-6;  // largest part of a cell beyond a box that is due to rounding

/// Cells on both sides of the centres of voxels along an axis.
struct BetweenCells {
  int low, high;
  float share;  ///< of `high`
};

}  // namespace

VolumeGeometry cell_geometry(const VolumeGeometry& volume, const CellSize& cell) {
  if (cell == kVoxelCells) return volume;
  VolumeGeometry cells = volume;
  Eigen::Vector3d first;
  for (int a = 0; a < 3; ++a) {
    cells.size[a] = std::max(1, static_cast<int>(std::ceil(volume.size[a] / cell[a] - kRounding)));
    cells.spacing_mm[a] *= cell[a];
    first[a] = 0.5 * (cell[a] - 1);
  }
  cells.origin_mm = volume.world_from_index() * first;
  cells.header = nullptr;
  return cells;
}

VoxelBox cells_around(const VoxelBox& voxels, const CellSize& cell, const std::array<int, 3>& volume_size) {
  if (cell == kVoxelCells) return voxels;
  VoxelBox cells;
  for (int a = 0; a < 3; ++a) {
    const int count = std::max(1, static_cast<int>(std::ceil(volume_size[a] / cell[a] - kRounding)));
    cells.first[a] = std::min(static_cast<int>(std::floor(voxels.first[a] / cell[a] + kRounding)), count - 1);
    const int end = static_cast<int>(std::ceil((voxels.first[a] + voxels.size[a]) / cell[a] - kRounding));
    cells.size[a] = std::clamp(end, cells.first[a] + 1, count) - cells.first[a];
  }
  return cells;
}

VoxelBox voxels_around(const VoxelBox& cells, const CellSize& cell, const std::array<int, 3>& volume_size) {
  if (cell == kVoxelCells) return cells;
  VoxelBox voxels;
  for (int a = 0; a < 3; ++a) {
    voxels.first[a] = static_cast<int>(std::floor(cells.first[a] * cell[a] + kRounding));
    const int end = static_cast<int>(std::ceil((cells.first[a] + cells.size[a]) * cell[a] - kRounding));
    voxels.size[a] = std::min(end, volume_size[a]) - voxels.first[a];
  }
  return voxels;
}

Mask mask_above(const VolumeGeometry& volume, const CellSize& cell, const VoxelBox& box,
                std::span<const std::uint16_t> values, float threshold) {
  SIMPLEXSEG_EXPECT(values.size() == box.voxel_count());
  Mask mask{volume, std::vector<std::uint8_t>(volume.voxel_count())};
  const VoxelBox voxels = voxels_around(box, cell, volume.size);
  const VoxelToCell to_cell(cell);
  std::array<std::vector<BetweenCells>, 3> between;
  for (int a = 0; a < 3; ++a) {
    between[a].reserve(voxels.size[a]);
    for (int v = voxels.first[a]; v < voxels.first[a] + voxels.size[a]; ++v) {
      const double at = std::clamp(to_cell(a, v) - box.first[a], 0.0, box.size[a] - 1.0);
      const int low = static_cast<int>(at);
      between[a].push_back({low, std::min(low + 1, box.size[a] - 1), static_cast<float>(at - low)});
    }
  }
  const auto mix = [](float a, float b, float share) { return a + share * (b - a); };
  std::vector<float> row(box.size[0]);
  for (int k = 0; k < voxels.size[2]; ++k) {
    const BetweenCells& z = between[2][k];
    for (int j = 0; j < voxels.size[1]; ++j) {
      const BetweenCells& y = between[1][j];
      const auto line = [&](int jj, int kk) { return values.data() + box.offset(0, jj, kk); };
      const std::uint16_t *const a = line(y.low, z.low), *const b = line(y.high, z.low), *const c = line(y.low, z.high),
                                 *const d = line(y.high, z.high);
      for (int i = 0; i < box.size[0]; ++i) row[i] = mix(mix(a[i], b[i], y.share), mix(c[i], d[i], y.share), z.share);
      std::uint8_t* const to =
          mask.voxels.data() +
          (std::size_t(k + voxels.first[2]) * volume.size[1] + j + voxels.first[1]) * volume.size[0] + voxels.first[0];
      for (int i = 0; i < voxels.size[0]; ++i) {
        const BetweenCells& x = between[0][i];
        to[i] = mix(row[x.low], row[x.high], x.share) > threshold;
      }
    }
  }
  return mask;
}

}  // namespace simplexseg
