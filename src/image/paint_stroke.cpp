// SPDX-License-Identifier: Apache-2.0
#include "image/paint_stroke.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/expect.h"
#include "image/plane_contour.h"
#include "image/voxel_box.h"

namespace simplexseg {
namespace {

double square_to_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d along = b - a, to = p - a;
  const double squared = along.squaredNorm(), t = squared > 0 ? std::clamp(to.dot(along) / squared, 0.0, 1.0) : 0;
  return (to - t * along).squaredNorm();
}

/// Voxels of `within` whose indices lie between two places.
VoxelBox box_between(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const VoxelBox& within) {
  VoxelBox box{};
  for (int a = 0; a < 3; ++a) {
    const double first = within.first[a], last = first + within.size[a] - 1.0;
    box.first[a] = static_cast<int>(std::clamp(std::ceil(low[a]), first, last + 1));
    box.size[a] = static_cast<int>(std::clamp(std::floor(high[a]), first - 1, last)) - box.first[a] + 1;
    box.size[a] = std::max(box.size[a], 0);
  }
  return box;
}

/// Voxels of `within` whose centres may be within the radius of two places.
VoxelBox box_around(const Eigen::Vector3d& a_index, const Eigen::Vector3d& b_index, double radius_mm,
                    const Eigen::Matrix3d& index_from_mm, const VoxelBox& within) {
  const Eigen::Vector3d reach = (radius_mm * index_from_mm.rowwise().norm()).array() + 0.5;
  return box_between(a_index.cwiseMin(b_index) - reach, a_index.cwiseMax(b_index) + reach, within);
}

VoxelPaint paint_of(const PaintStroke& stroke) { return stroke.inside ? VoxelPaint::Inside : VoxelPaint::Outside; }

StrokeVoxels voxels_of_brush(const PaintStroke& stroke, const VolumeGeometry& grid, const VoxelBox& within) {
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
  for (std::size_t s = 0; s < segments; ++s) found.box = united(found.box, box_of(s));
  found.voxels.assign(found.box.voxel_count(), VoxelPaint::None);
  const VoxelPaint set = paint_of(stroke);
  if (found.voxels.empty()) return {};
  const auto at = [&](int i, int j, int k) -> VoxelPaint& {
    return found.voxels[found.box.offset(i - found.box.first[0], j - found.box.first[1], k - found.box.first[2])];
  };
  const double square_mm = stroke.radius_mm * stroke.radius_mm;
  for (std::size_t s = 0; s < segments; ++s) {
    const Eigen::Vector3d &a = vertices[s], &b = vertices[std::min(s + 1, vertices.size() - 1)];
    const VoxelBox box = box_of(s);
    for (int k = box.first[2]; k < box.first[2] + box.size[2]; ++k)
      for (int j = box.first[1]; j < box.first[1] + box.size[1]; ++j)
        for (int i = box.first[0]; i < box.first[0] + box.size[0]; ++i) {
          VoxelPaint& voxel = at(i, j, k);
          if (voxel == set) continue;
          const Eigen::Vector3d mm = world * Eigen::Vector3d(i, j, k);
          if (!is_in_slice(mm)) continue;
          if (square_to_segment(in_plane(mm), a, b) <= square_mm) voxel = set;
        }
  }
  for (const Eigen::Vector3d& vertex : vertices) {
    const Eigen::Vector3d nearest = (index * vertex).array().round();
    bool in_box = is_in_slice(world * nearest);
    for (int a = 0; a < 3; ++a)
      in_box &= nearest[a] >= found.box.first[a] && nearest[a] < found.box.first[a] + found.box.size[a];
    if (in_box) at(static_cast<int>(nearest[0]), static_cast<int>(nearest[1]), static_cast<int>(nearest[2])) = set;
  }
  return found;
}

/// Voxels of `within` in which the interior of a contour may lie.
VoxelBox box_of_contour(const PaintStroke& stroke, const VolumeGeometry& grid, const VoxelBox& within) {
  const Eigen::Affine3d index = grid.index_from_world();
  const Eigen::Vector3d extent_mm =
      grid.spacing_mm.cwiseProduct(Eigen::Vector3d(grid.size[0], grid.size[1], grid.size[2]));
  const double reach_mm = stroke.brush.thickness_mm > 0
                              ? 0.5 * stroke.brush.thickness_mm
                              : extent_mm.norm() + (stroke.vertices_mm[0] - grid.centre_mm()).norm();
  Eigen::Vector3d low = index * stroke.vertices_mm[0], high = low;
  const Eigen::Vector3d& normal = stroke.brush.normal;
  for (const Eigen::Vector3d& place : stroke.vertices_mm) {
    const Eigen::Vector3d vertex = place - normal.dot(place - stroke.vertices_mm[0]) * normal;
    for (const double side_mm : {-reach_mm, reach_mm}) {
      const Eigen::Vector3d at = index * (vertex + side_mm * normal);
      low = low.cwiseMin(at), high = high.cwiseMax(at);
    }
  }
  const Eigen::Vector3d rounding = Eigen::Vector3d::Constant(1e-6);
  return box_between(low - rounding, high + rounding, within);
}

StrokeVoxels voxels_of_contour(const PaintStroke& stroke, const VolumeGeometry& grid, const VoxelBox& within) {
  const Eigen::Affine3d world = grid.world_from_index();
  const Eigen::Vector3d &normal = stroke.brush.normal, origin = stroke.vertices_mm[0];
  const PlaneContour contour(stroke.vertices_mm, normal);
  StrokeVoxels found{box_of_contour(stroke, grid, within), {}};
  found.voxels.assign(found.box.voxel_count(), VoxelPaint::None);
  if (found.voxels.empty()) return {};
  // Along an axis that is parallel to the normal, all voxels have the same place in the plane.
  int along = 3;
  for (int a = 0; a < 3; ++a)
    if (contour.in_plane(origin + world.linear().col(a)).norm() < 1e-9 * world.linear().col(a).norm()) along = a;
  enum class Enclosed : std::uint8_t { Unknown, No, Yes };
  std::array<int, 3> layer = found.box.size;
  if (along < 3) layer[along] = 1;
  const VoxelBox columns{{0, 0, 0}, layer};
  std::vector<Enclosed> enclosed(columns.voxel_count(), Enclosed::Unknown);
  const double half = 0.5 * stroke.brush.thickness_mm;
  std::size_t voxel = 0;
  for (int k = 0; k < found.box.size[2]; ++k)
    for (int j = 0; j < found.box.size[1]; ++j)
      for (int i = 0; i < found.box.size[0]; ++i, ++voxel) {
        const Eigen::Vector3d mm =
            world * Eigen::Vector3d(found.box.first[0] + i, found.box.first[1] + j, found.box.first[2] + k);
        const double off = normal.dot(mm - origin);
        if (half > 0 && !(off >= -half && off < half)) continue;
        Enclosed& column = enclosed[columns.offset(along == 0 ? 0 : i, along == 1 ? 0 : j, along == 2 ? 0 : k)];
        if (column == Enclosed::Unknown) column = contour.encloses(mm) ? Enclosed::Yes : Enclosed::No;
        if (column == Enclosed::Yes) found.voxels[voxel] = paint_of(stroke);
      }
  return found;
}

StrokeVoxels voxels_of_set(const PaintVoxels& set, const VolumeGeometry& grid, const VoxelBox& within) {
  const VoxelBox all{{0, 0, 0}, set.box.size};
  const Eigen::Affine3d from_grid = set.box.index_from_world() * grid.world_from_index();
  const Eigen::Affine3d to_grid = grid.index_from_world() * set.box.world_from_index();
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d at;
    for (int a = 0; a < 3; ++a) at[a] = (corner >> a & 1) != 0 ? set.box.size[a] - 0.5 : -0.5;
    at = to_grid * at;
    low = low.cwiseMin(at), high = high.cwiseMax(at);
  }
  StrokeVoxels found{box_between(low, high, within), {}};
  found.voxels.assign(found.box.voxel_count(), VoxelPaint::None);
  if (found.voxels.empty()) return {};
  std::size_t voxel = 0;
  for (int k = 0; k < found.box.size[2]; ++k)
    for (int j = 0; j < found.box.size[1]; ++j)
      for (int i = 0; i < found.box.size[0]; ++i, ++voxel) {
        const Eigen::Vector3d at =
            from_grid * Eigen::Vector3d(found.box.first[0] + i, found.box.first[1] + j, found.box.first[2] + k);
        std::array<int, 3> index;
        bool in = true;
        for (int a = 0; a < 3; ++a) {
          index[a] = static_cast<int>(std::floor(at[a] + 0.5));
          in = in && index[a] >= 0 && index[a] < set.box.size[a];
        }
        if (in) found.voxels[voxel] = set.voxels[all.offset(index[0], index[1], index[2])];
      }
  return found;
}

/// For each axis of a set of voxels and each of its indices, the voxels of a grid whose centres it contains: begin,
/// end.
using AxisRanges = std::array<std::vector<std::pair<int, int>>, 3>;

/// None if the axes are not parallel in the same order and direction.
std::optional<AxisRanges> ranges_of(const VolumeGeometry& set, const VolumeGeometry& grid) {
  const Eigen::Affine3d from_grid = set.index_from_world() * grid.world_from_index();
  const Eigen::Matrix3d off_axis = from_grid.linear() - Eigen::Matrix3d(from_grid.linear().diagonal().asDiagonal());
  const double extent = *std::ranges::max_element(grid.size);
  if (off_axis.cwiseAbs().maxCoeff() * extent > 1e-3 || from_grid.linear().diagonal().minCoeff() <= 0)
    return std::nullopt;
  AxisRanges ranges;
  for (int a = 0; a < 3; ++a) {
    ranges[a].resize(static_cast<std::size_t>(set.size[a]));
    for (int at = 0; at < grid.size[a]; ++at) {
      const double index = std::floor(from_grid.linear()(a, a) * at + from_grid.translation()[a] + 0.5);
      if (!(index >= 0 && index < set.size[a])) continue;
      auto& [begin, end] = ranges[a][static_cast<std::size_t>(index)];
      if (begin == end) begin = at;
      end = at + 1;
    }
  }
  return ranges;
}

}  // namespace

StrokeVoxels voxels_of(const PaintStroke& stroke, const VolumeGeometry& grid, const VoxelBox& within) {
  if (stroke.brush.shape == PaintBrush::Shape::Voxels) {
    SIMPLEXSEG_EXPECT(stroke.voxels);
    return voxels_of_set(*stroke.voxels, grid, within);
  }
  SIMPLEXSEG_EXPECT(!stroke.vertices_mm.empty());
  return stroke.brush.shape == PaintBrush::Shape::Contour ? voxels_of_contour(stroke, grid, within)
                                                          : voxels_of_brush(stroke, grid, within);
}

StrokeVoxels voxels_of(const PaintStroke& stroke, const VolumeGeometry& grid) {
  return voxels_of(stroke, grid, VoxelBox{{0, 0, 0}, grid.size});
}

void for_each_voxel(const PaintStroke& stroke, const VolumeGeometry& grid,
                    const std::function<void(int, int, int, bool)>& use) {
  if (stroke.brush.shape != PaintBrush::Shape::Voxels) return voxels_of(stroke, grid).for_each(use);
  SIMPLEXSEG_EXPECT(stroke.voxels);
  const PaintVoxels& set = *stroke.voxels;
  const std::optional<AxisRanges> ranges = ranges_of(set.box, grid);
  if (!ranges) return voxels_of(stroke, grid).for_each(use);
  const auto& [along_i, along_j, along_k] = *ranges;
  std::size_t v = 0;
  for (const auto& [k_begin, k_end] : along_k)
    for (const auto& [j_begin, j_end] : along_j)
      for (const auto& [i_begin, i_end] : along_i) {
        const VoxelPaint paint = set.voxels[v++];
        if (paint == VoxelPaint::None) continue;
        for (int k = k_begin; k < k_end; ++k)
          for (int j = j_begin; j < j_end; ++j)
            for (int i = i_begin; i < i_end; ++i) use(i, j, k, paint == VoxelPaint::Inside);
      }
}

void apply(const PaintStroke& stroke, Mask& mask) {
  const VoxelBox all{{0, 0, 0}, mask.geometry.size};
  for_each_voxel(stroke, mask.geometry,
                 [&](int i, int j, int k, bool inside) { mask.voxels[all.offset(i, j, k)] = inside; });
}

}  // namespace simplexseg
