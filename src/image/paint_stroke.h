// SPDX-License-Identifier: Apache-2.0
// Strokes of a brush that set voxels exactly.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "image/distance_map.h"
#include "image/mask.h"

namespace simplexseg {

/// Shape of a brush: a ball, or a disc in a slice.
struct PaintBrush {
  enum class Shape : std::uint8_t { None, Ball, Disc };
  Shape shape = Shape::None;        ///< None: no brush, nothing is painted
  Eigen::Vector3d normal{0, 0, 0};  ///< disc: unit normal of its slice
  double thickness_mm = 0;          ///< disc: thickness of the slice, above 0; ball: 0

  static PaintBrush ball() { return {Shape::Ball}; }
  static PaintBrush disc(const Eigen::Vector3d& normal, double thickness_mm) {
    return {Shape::Disc, normal, thickness_mm};
  }
  bool paints() const { return shape != Shape::None; }
  bool operator==(const PaintBrush&) const = default;
};

/// Stroke that puts voxels into an object or takes them out of it.
struct PaintStroke {
  bool inside = true;
  std::vector<Eigen::Vector3d> vertices_mm;  ///< path of the centre of the brush, LPS; at least one vertex
  double radius_mm = 1;
  PaintBrush brush = PaintBrush::ball();

  bool operator==(const PaintStroke&) const = default;
};

/// Voxels of a stroke: 1 for each voxel of a box that it sets, else 0.
struct StrokeVoxels {
  VoxelBox box{};  ///< lies in the grid; empty (size 0) if the stroke sets no voxel
  std::vector<std::uint8_t> voxels;

  /// Calls use(i, j, k) with the index in the grid of each voxel that the stroke sets.
  template <class Use>
  void for_each(const Use& use) const {
    std::size_t v = 0;
    for (int k = 0; k < box.size[2]; ++k)
      for (int j = 0; j < box.size[1]; ++j)
        for (int i = 0; i < box.size[0]; ++i, ++v)
          if (voxels[v]) use(box.first[0] + i, box.first[1] + j, box.first[2] + k);
  }
};
/// Voxels of a grid whose centres are within the radius of the path, and those nearest to a vertex. For a disc,
/// distances are those in its slice, and only voxels at most half of the thickness from it are set (at exactly half: on
/// one side alone). `within`: only voxels of this box.
StrokeVoxels voxels_of(const PaintStroke& stroke, const VolumeGeometry& grid, const VoxelBox& within);
StrokeVoxels voxels_of(const PaintStroke& stroke, const VolumeGeometry& grid);

/// Sets the voxels of a stroke in a mask to its value.
void apply(const PaintStroke& stroke, Mask& mask);

}  // namespace simplexseg
