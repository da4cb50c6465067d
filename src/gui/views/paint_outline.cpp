// SPDX-License-Identifier: Apache-2.0
#include "gui/views/paint_outline.h"

#include <Eigen/Geometry>
#include <utility>

#include "session/paint.h"

namespace simplexseg {
namespace {

/// Grid of one slice whose voxels are the texels.
VolumeGeometry grid_of(const SliceGrid& slice, double spacing_mm) {
  VolumeGeometry grid;
  grid.size = {slice.width, slice.height, 1};
  grid.spacing_mm = {slice.step_u_mm.norm(), slice.step_v_mm.norm(), spacing_mm};
  grid.origin_mm = slice.origin_mm;
  grid.direction.col(0) = slice.step_u_mm.normalized();
  grid.direction.col(1) = slice.step_v_mm.normalized();
  grid.direction.col(2) = grid.direction.col(0).cross(grid.direction.col(1));
  return grid;
}

}  // namespace

PaintOutline outline_of(std::span<const PaintStroke> strokes, const SliceGrid& slice, double spacing_mm) {
  PaintOutline outline;
  const VolumeGeometry grid = grid_of(slice, spacing_mm);
  std::vector<StrokeVoxels> found;
  for (const PaintStroke& stroke : strokes) {
    StrokeVoxels voxels = voxels_of(stroke, grid);
    if (!voxels.voxels.empty()) found.push_back(std::move(voxels));
  }
  if (found.empty()) return outline;
  std::vector<VoxelPaint> state(static_cast<std::size_t>(slice.width) * slice.height, VoxelPaint::None);
  for (const StrokeVoxels& voxels : found) {
    voxels.for_each([&](int i, int j, int, bool inside) {
      state[static_cast<std::size_t>(j) * slice.width + i] = inside ? VoxelPaint::Inside : VoxelPaint::Outside;
    });
  }
  const auto state_at = [&](int i, int j) {
    if (i < 0 || j < 0 || i >= slice.width || j >= slice.height) return VoxelPaint::None;
    return state[static_cast<std::size_t>(j) * slice.width + i];
  };
  const auto corner = [&](int i, int j) -> Eigen::Vector3f {
    return (slice.corner_mm() + i * slice.step_u_mm + j * slice.step_v_mm).cast<float>();
  };
  for (int j = 0; j < slice.height; ++j)
    for (int i = 0; i < slice.width; ++i) {
      const VoxelPaint here = state_at(i, j);
      if (here == VoxelPaint::None) continue;
      std::vector<Eigen::Vector3f>& ends = here == VoxelPaint::Inside ? outline.painted : outline.erased;
      const auto add = [&](VoxelPaint beside, int i0, int j0, int i1, int j1) {
        if (beside == here) return;
        ends.push_back(corner(i0, j0));
        ends.push_back(corner(i1, j1));
      };
      add(state_at(i - 1, j), i, j, i, j + 1);
      add(state_at(i + 1, j), i + 1, j, i + 1, j + 1);
      add(state_at(i, j - 1), i, j, i + 1, j);
      add(state_at(i, j + 1), i, j + 1, i + 1, j + 1);
    }
  return outline;
}

const PaintOutline& PaintLayer::in_slice(const Scene& scene, const SliceGrid& slice, double spacing_mm) {
  std::vector<std::vector<PaintStroke>> paint;
  for (const MeshItem& item : scene.meshes)
    if (item.visible) paint.push_back(paint_of(scene, item.id));
  if (paint == paint_ && slice == slice_) return outline_;
  outline_ = {};
  for (const std::vector<PaintStroke>& strokes : paint) {
    const PaintOutline outline = outline_of(strokes, slice, spacing_mm);
    outline_.painted.insert(outline_.painted.end(), outline.painted.begin(), outline.painted.end());
    outline_.erased.insert(outline_.erased.end(), outline.erased.begin(), outline.erased.end());
  }
  paint_ = std::move(paint), slice_ = slice;
  return outline_;
}

}  // namespace simplexseg
