// SPDX-License-Identifier: Apache-2.0
#include "image/paint_stroke.h"

#include <algorithm>
#include <cmath>

#include "core/expect.h"

namespace simplexseg {
namespace {

double square_to_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d along = b - a, to = p - a;
  const double squared = along.squaredNorm(), t = squared > 0 ? std::clamp(to.dot(along) / squared, 0.0, 1.0) : 0;
  return (to - t * along).squaredNorm();
}

/// Voxels of `within` whose centres may be within the radius of two places.
VoxelBox box_around(const Eigen::Vector3d& a_index, const Eigen::Vector3d& b_index, double radius_mm,
                    const Eigen::Matrix3d& index_from_mm, const VoxelBox& within) {
  VoxelBox box{};
  for (int a = 0; a < 3; ++a) {
    const double reach = radius_mm * index_from_mm.row(a).norm() + 0.5;
    const double low = std::min(a_index[a], b_index[a]) - reach, high = std::max(a_index[a], b_index[a]) + reach;
    const double first = within.first[a], last = first + within.size[a] - 1.0;
    box.first[a] = static_cast<int>(std::clamp(std::ceil(low), first, last + 1));
    box.size[a] = static_cast<int>(std::clamp(std::floor(high), first - 1, last)) - box.first[a] + 1;
    box.size[a] = std::max(box.size[a], 0);
  }
  return box;
}

void extend(VoxelBox& box, const VoxelBox& by) {
  if (by.voxel_count() == 0) return;
  if (box.voxel_count() == 0) {
    box = by;
    return;
  }
  for (int a = 0; a < 3; ++a) {
    const int end = std::max(box.first[a] + box.size[a], by.first[a] + by.size[a]);
    box.first[a] = std::min(box.first[a], by.first[a]);
    box.size[a] = end - box.first[a];
  }
}

}  // namespace

StrokeVoxels voxels_of(const PaintStroke& stroke, const VolumeGeometry& grid, const VoxelBox& within) {
  SIMPLEXSEG_EXPECT(!stroke.vertices_mm.empty());
  const Eigen::Affine3d world = grid.world_from_index(), index = world.inverse();
  const bool is_disc = stroke.brush.shape == PaintBrush::Shape::Disc;
  const Eigen::Vector3d& normal = stroke.brush.normal;
  const auto off_slice_mm = [&](const Eigen::Vector3d& mm) { return normal.dot(mm - stroke.vertices_mm[0]); };
  const auto is_in_slice = [&](const Eigen::Vector3d& mm) {
    const double off = off_slice_mm(mm), half = 0.5 * stroke.brush.thickness_mm;
    return !is_disc || (off >= -half && off < half);
  };
  const auto in_plane = [&](const Eigen::Vector3d& mm) -> Eigen::Vector3d {
    return is_disc ? Eigen::Vector3d(mm - off_slice_mm(mm) * normal) : mm;
  };
  std::vector<Eigen::Vector3d> vertices;
  for (const Eigen::Vector3d& vertex : stroke.vertices_mm) vertices.push_back(in_plane(vertex));
  const double reach_mm = stroke.radius_mm + (is_disc ? 0.5 * stroke.brush.thickness_mm : 0);
  // A segment for each pair of neighbouring vertices; a single vertex is a segment without length.
  const std::size_t segments = std::max<std::size_t>(vertices.size() - 1, 1);
  const auto box_of = [&](std::size_t s) {
    const Eigen::Vector3d &a = vertices[s], &b = vertices[std::min(s + 1, vertices.size() - 1)];
    return box_around(index * a, index * b, reach_mm, index.linear(), within);
  };
  StrokeVoxels found;
  for (std::size_t s = 0; s < segments; ++s) extend(found.box, box_of(s));
  found.voxels.assign(found.box.voxel_count(), 0);
  if (found.voxels.empty()) return {};
  const auto at = [&](int i, int j, int k) -> std::uint8_t& {
    return found.voxels[found.box.offset(i - found.box.first[0], j - found.box.first[1], k - found.box.first[2])];
  };
  const double square_mm = stroke.radius_mm * stroke.radius_mm;
  for (std::size_t s = 0; s < segments; ++s) {
    const Eigen::Vector3d &a = vertices[s], &b = vertices[std::min(s + 1, vertices.size() - 1)];
    const VoxelBox box = box_of(s);
    for (int k = box.first[2]; k < box.first[2] + box.size[2]; ++k)
      for (int j = box.first[1]; j < box.first[1] + box.size[1]; ++j)
        for (int i = box.first[0]; i < box.first[0] + box.size[0]; ++i) {
          std::uint8_t& voxel = at(i, j, k);
          if (voxel) continue;
          const Eigen::Vector3d mm = world * Eigen::Vector3d(i, j, k);
          if (!is_in_slice(mm)) continue;
          voxel = square_to_segment(in_plane(mm), a, b) <= square_mm;
        }
  }
  for (const Eigen::Vector3d& vertex : vertices) {
    const Eigen::Vector3d nearest = (index * vertex).array().round();
    bool in_box = is_in_slice(world * nearest);
    for (int a = 0; a < 3; ++a)
      in_box &= nearest[a] >= found.box.first[a] && nearest[a] < found.box.first[a] + found.box.size[a];
    if (in_box) at(static_cast<int>(nearest[0]), static_cast<int>(nearest[1]), static_cast<int>(nearest[2])) = 1;
  }
  return found;
}

StrokeVoxels voxels_of(const PaintStroke& stroke, const VolumeGeometry& grid) {
  return voxels_of(stroke, grid, VoxelBox{{0, 0, 0}, grid.size});
}

void apply(const PaintStroke& stroke, Mask& mask) {
  const VoxelBox all{{0, 0, 0}, mask.geometry.size};
  voxels_of(stroke, mask.geometry).for_each([&](int i, int j, int k) {
    mask.voxels[all.offset(i, j, k)] = stroke.inside;
  });
}

}  // namespace simplexseg
