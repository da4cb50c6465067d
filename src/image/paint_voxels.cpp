// SPDX-License-Identifier: Apache-2.0
#include "image/paint_voxels.h"

#include <algorithm>
#include <numeric>

#include "core/error.h"
#include "core/expect.h"
#include "image/voxel_rows.h"

namespace simplexseg {

VolumeGeometry grid_of_box(const VolumeGeometry& grid, const VoxelBox& box) {
  VolumeGeometry part = grid;
  part.size = box.size;
  part.origin_mm = grid.world_from_index() * Eigen::Vector3d(box.first[0], box.first[1], box.first[2]);
  part.header = nullptr;
  return part;
}

std::shared_ptr<const PaintVoxels> difference_of(const Mask& before, const Mask& after) {
  SIMPLEXSEG_EXPECT(before.geometry.size == after.geometry.size && before.voxels.size() == after.voxels.size());
  Mask changed{before.geometry, before.voxels};
  for (std::size_t v = 0; v < changed.voxels.size(); ++v) changed.voxels[v] = before.voxels[v] != after.voxels[v];
  const VoxelBox box = bounding_box(changed, changed);
  if (box.voxel_count() == 0) return nullptr;
  auto paint = std::make_shared<PaintVoxels>();
  paint->box = grid_of_box(before.geometry, box);
  paint->voxels.assign(box.voxel_count(), VoxelPaint::None);
  for_each_row(box, {{0, 0, 0}, before.geometry.size}, [&](std::size_t in_box, std::size_t in_mask) {
    for (int i = 0; i < box.size[0]; ++i)
      if (changed.voxels[in_mask + i])
        paint->voxels[in_box + i] = after.voxels[in_mask + i] ? VoxelPaint::Inside : VoxelPaint::Outside;
  });
  return paint;
}

std::vector<std::uint32_t> runs_of(std::span<const VoxelPaint> voxels) {
  std::vector<std::uint32_t> runs;
  for (std::size_t v = 0; v < voxels.size();)
    for (const VoxelPaint value : {VoxelPaint::None, VoxelPaint::Inside, VoxelPaint::Outside}) {
      const std::size_t first = v;
      while (v < voxels.size() && voxels[v] == value) ++v;
      runs.push_back(static_cast<std::uint32_t>(v - first));
    }
  return runs;
}

std::vector<VoxelPaint> voxels_of_runs(std::span<const std::uint32_t> runs, std::size_t count) {
  if (std::accumulate(runs.begin(), runs.end(), std::size_t{0}) != count)
    throw Error("painted voxels", "the lengths of their runs do not add up to the number of voxels of their box",
                "correct the runs");
  std::vector<VoxelPaint> voxels;
  voxels.reserve(count);
  for (std::size_t r = 0; r < runs.size(); ++r) voxels.insert(voxels.end(), runs[r], static_cast<VoxelPaint>(r % 3));
  return voxels;
}

}  // namespace simplexseg
