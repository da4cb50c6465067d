// SPDX-License-Identifier: Apache-2.0
#include "field/evidence_box.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "field/coarse_image.h"

namespace simplexseg {
namespace {

constexpr double kLeastCell = 1.3;  // voxels; neighbours of smaller cells share most of their voxels

/// Box from index `low` to `high`, both included, with the same margin in mm along all axes, within the volume.
VoxelBox with_margin(const Eigen::Array3d& low, const Eigen::Array3d& high, double share, double least_voxels,
                     const VolumeGeometry& geometry) {
  const Eigen::Array3d spacing = geometry.spacing_mm.array();
  const double margin_mm = std::max(least_voxels * spacing.minCoeff(), share * ((high - low) * spacing).maxCoeff());
  VoxelBox box;
  for (int a = 0; a < 3; ++a) {
    const double margin = margin_mm / spacing[a] + 1;
    box.first[a] = static_cast<int>(std::clamp(std::floor(low[a] - margin), 0.0, geometry.size[a] - 1.0));
    const int last =
        static_cast<int>(std::clamp(std::ceil(high[a] + margin), double(box.first[a]), geometry.size[a] - 1.0));
    box.size[a] = last - box.first[a] + 1;
  }
  return box;
}

}  // namespace

VoxelBox box_around_marks(std::span<const Mark> marks, const VolumeGeometry& geometry, double margin_share,
                          double least_margin) {
  const Eigen::Affine3d index_from_world = geometry.index_from_world();
  Eigen::Array3d low = Eigen::Array3d::Constant(1e9), high = -low;
  for (const Mark& mark : marks) {
    const Eigen::Array3d centre = (index_from_world * mark.position_mm).array();
    const double radius_mm = mark.kind == MarkKind::Boundary ? 2 * mark.radius_mm : mark.radius_mm;
    const Eigen::Array3d extent = radius_mm * index_from_world.linear().rowwise().norm().array();
    low = low.min(centre - extent);
    high = high.max(centre + extent);
  }
  return with_margin(low, high, margin_share, least_margin, geometry);
}

double marked_extent(std::span<const Mark> marks) {
  Eigen::Array3d low = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Mark& mark : marks) {
    if (mark.kind == MarkKind::Outside) continue;
    low = low.min(mark.position_mm.array() - mark.radius_mm);
    high = high.max(mark.position_mm.array() + mark.radius_mm);
  }
  return std::max(0.0, (high - low).maxCoeff());
}

VoxelBox box_around_bounds(const std::array<Eigen::Vector3d, 2>& corners_mm, const VolumeGeometry& geometry,
                           double least_margin) {
  const Eigen::Affine3d index_from_world = geometry.index_from_world();
  Eigen::Array3d low = Eigen::Array3d::Constant(1e9), high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d mm(corners_mm[corner & 1].x(), corners_mm[corner >> 1 & 1].y(), corners_mm[corner >> 2].z());
    const Eigen::Array3d index = (index_from_world * mm).array();
    low = low.min(index);
    high = high.max(index);
  }
  return with_margin(low, high, 0, least_margin, geometry);
}

VoxelBox box_around(const VoxelBox& a, const VoxelBox& b) {
  if (a.voxel_count() == 0) return b;
  if (b.voxel_count() == 0) return a;
  VoxelBox box;
  for (int x = 0; x < 3; ++x) {
    box.first[x] = std::min(a.first[x], b.first[x]);
    box.size[x] = std::max(a.first[x] + a.size[x], b.first[x] + b.size[x]) - box.first[x];
  }
  return box;
}

CellSize cell_size_for(const VoxelBox& voxels, const VolumeGeometry& volume, double scale_mm,
                       const EvidenceSettings& settings) {
  constexpr double kLargestPart = 0.93;  // share of the largest block of the prior, see width_for()
  const double voxel_mm = volume.spacing_mm.minCoeff(), block_mm = kLargestPart * scale_mm / settings.blocks_per_scale;
  const auto fits = [&](const CellSize& cell) {
    return static_cast<double>(cells_around(voxels, cell, volume.size).voxel_count()) <= settings.max_cells;
  };
  if (fits(kVoxelCells)) return kVoxelCells;
  for (int parts = kWidestBlock;; --parts) {
    // Below one part, blocks are larger than the prior requires for the scale of the object.
    const double cell_mm = parts > 0 ? block_mm / parts : block_mm * std::exp2(0.25 * (1 - parts));
    CellSize cell;
    for (int a = 0; a < 3; ++a) cell[a] = std::max(1.0, cell_mm / volume.spacing_mm[a]);
    if (cell_mm > kLeastCell * voxel_mm && fits(cell)) return cell;
  }
}

VoxelBox grow_around(const VoxelBox& box, const VoxelBox& object, const VolumeGeometry& geometry) {
  Eigen::Array3d low, high;
  for (int a = 0; a < 3; ++a) {
    low[a] = object.first[a];
    high[a] = object.first[a] + object.size[a] - 1;
  }
  const VoxelBox least = with_margin(low, high, 0.15, 5, geometry), target = with_margin(low, high, 0.3, 10, geometry);
  VoxelBox grown = box;
  for (int a = 0; a < 3; ++a) {
    int first = box.first[a], end = box.first[a] + box.size[a];
    if (least.first[a] < first) first = target.first[a];
    if (least.first[a] + least.size[a] > end) end = target.first[a] + target.size[a];
    grown.first[a] = first;
    grown.size[a] = end - first;
  }
  return grown;
}

bool is_thin(double mm3, const VoxelBox& bounds, const Eigen::Vector3d& cell_mm) {
  constexpr double kLeastFill = 0.2;             // share of the bounding box
  constexpr double kTube = 0.25, kPlate = 0.17;  // middle extent per largest one; smallest per middle one
  Eigen::Array3d extent_mm = cell_mm.array();
  for (int a = 0; a < 3; ++a) extent_mm[a] *= bounds.size[a];
  const double box_mm3 = extent_mm.prod();
  std::sort(extent_mm.begin(), extent_mm.end());
  return mm3 < kLeastFill * box_mm3 || extent_mm[1] < kTube * extent_mm[2] || extent_mm[0] < kPlate * extent_mm[1];
}

bool VolumeInBoxes::add(double mm3, const VoxelBox& box) {
  constexpr double kConstant = 1.05, kSpreading = 1.3;
  if (constant_mm3_ > 0 && mm3 > kSpreading * constant_mm3_) return true;
  if (box != last_in_ && last_mm3_ > 0 && mm3 <= kConstant * last_mm3_)
    constant_mm3_ = std::max(mm3, last_mm3_), constant_in_ = box;
  last_mm3_ = mm3, last_in_ = box;
  return false;
}

}  // namespace simplexseg
