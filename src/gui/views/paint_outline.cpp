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

/// Effect of strokes on each texel of a slice; empty if they set nothing.
std::vector<VoxelPaint> texels_of(std::span<const PaintStroke> strokes, const SliceGrid& slice, double spacing_mm) {
  const VolumeGeometry grid = grid_of(slice, spacing_mm);
  std::vector<VoxelPaint> texels;
  for (const PaintStroke& stroke : strokes) {
    const StrokeVoxels found = voxels_of(stroke, grid);
    if (texels.empty() && !found.voxels.empty())
      texels.assign(static_cast<std::size_t>(slice.width) * slice.height, VoxelPaint::None);
    found.for_each([&](int i, int j, int, bool inside) {
      texels[static_cast<std::size_t>(j) * slice.width + i] = inside ? VoxelPaint::Inside : VoxelPaint::Outside;
    });
  }
  return texels;
}

/// Calls side(value, start, end) for each side of a texel with another value beside it, ends in mm.
template <class Side>
void for_each_side(const std::vector<VoxelPaint>& texels, const SliceGrid& slice, const Side& side) {
  if (texels.empty()) return;
  const auto value_at = [&](int i, int j) {
    if (i < 0 || j < 0 || i >= slice.width || j >= slice.height) return VoxelPaint::None;
    return texels[static_cast<std::size_t>(j) * slice.width + i];
  };
  const auto corner = [&](int i, int j) -> Eigen::Vector3f {
    return (slice.corner_mm() + i * slice.step_u_mm + j * slice.step_v_mm).cast<float>();
  };
  for (int j = 0; j < slice.height; ++j)
    for (int i = 0; i < slice.width; ++i) {
      const VoxelPaint here = value_at(i, j);
      if (here == VoxelPaint::None) continue;
      if (value_at(i - 1, j) != here) side(here, corner(i, j), corner(i, j + 1));
      if (value_at(i + 1, j) != here) side(here, corner(i + 1, j), corner(i + 1, j + 1));
      if (value_at(i, j - 1) != here) side(here, corner(i, j), corner(i + 1, j));
      if (value_at(i, j + 1) != here) side(here, corner(i, j + 1), corner(i + 1, j + 1));
    }
}

}  // namespace

PaintOutline outline_of(std::span<const PaintStroke> strokes, std::span<const PaintStroke> frozen,
                        const SliceGrid& slice, double spacing_mm) {
  PaintOutline outline;
  for_each_side(texels_of(strokes, slice, spacing_mm), slice,
                [&](VoxelPaint value, const auto& start, const auto& end) {
                  std::vector<Eigen::Vector3f>& ends = value == VoxelPaint::Inside ? outline.painted : outline.erased;
                  ends.push_back(start), ends.push_back(end);
                });
  std::vector<VoxelPaint> kept = texels_of(frozen, slice, spacing_mm);
  for (VoxelPaint& texel : kept)
    if (texel == VoxelPaint::Outside) texel = VoxelPaint::Inside;
  for_each_side(kept, slice, [&](VoxelPaint, const auto& start, const auto& end) {
    outline.frozen.push_back(start), outline.frozen.push_back(end);
  });
  return outline;
}

const PaintOutline& PaintLayer::in_slice(const Scene& scene, const SliceGrid& slice, double spacing_mm) {
  std::vector<MeshPaint> paint;
  for (const MeshItem& item : scene.meshes) {
    if (!item.visible) continue;
    MeshPaint& of_mesh = paint.emplace_back();
    for (const UserPoint& point : scene.points)
      if (point.mesh == item.id && point.is_paint())
        (point.edit == VoxelEdit::Freeze ? of_mesh.frozen : of_mesh.strokes).push_back(paint_stroke_of(point));
  }
  if (paint == paint_ && slice == slice_) return outline_;
  outline_ = {};
  for (const MeshPaint& of_mesh : paint) {
    const PaintOutline outline = outline_of(of_mesh.strokes, of_mesh.frozen, slice, spacing_mm);
    outline_.painted.insert(outline_.painted.end(), outline.painted.begin(), outline.painted.end());
    outline_.erased.insert(outline_.erased.end(), outline.erased.begin(), outline.erased.end());
    outline_.frozen.insert(outline_.frozen.end(), outline.frozen.begin(), outline.frozen.end());
  }
  paint_ = std::move(paint), slice_ = slice;
  return outline_;
}

}  // namespace simplexseg
