// SPDX-License-Identifier: Apache-2.0
// Paint: strokes of a brush, contours and sets of voxels that set voxels exactly.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "image/distance_map.h"
#include "image/mask.h"
#include "image/paint_voxels.h"

namespace simplexseg {

/// Shape of paint: the path of a ball, or of a disc in a slice; the interior of a closed contour in a slice; or a set
/// of voxels.
struct PaintBrush {
  enum class Shape : std::uint8_t { None, Ball, Disc, Contour, Voxels };
  Shape shape = Shape::None;        ///< None: no brush, nothing is painted
  Eigen::Vector3d normal{0, 0, 0};  ///< disc and contour: unit normal of the slice; otherwise 0
  /// Disc and contour: thickness of the slice; 0 for a contour: through the whole volume. Otherwise 0.
  double thickness_mm = 0;

  static PaintBrush ball() { return {Shape::Ball}; }
  static PaintBrush disc(const Eigen::Vector3d& normal, double thickness_mm) {
    return {Shape::Disc, normal, thickness_mm};
  }
  static PaintBrush contour(const Eigen::Vector3d& normal, double thickness_mm) {
    return {Shape::Contour, normal, thickness_mm};
  }
  bool paints() const { return shape != Shape::None; }
  bool has_radius() const { return shape == Shape::Ball || shape == Shape::Disc; }
  bool operator==(const PaintBrush&) const = default;
};

/// Paint that puts voxels into an object or takes them out of it.
struct PaintStroke {
  bool inside = true;                        ///< ignored for a set of voxels
  std::vector<Eigen::Vector3d> vertices_mm;  ///< path of the centre of the brush, or contour, LPS; at least one vertex
  double radius_mm = 1;                      ///< radius of the brush
  PaintBrush brush = PaintBrush::ball();
  std::shared_ptr<const PaintVoxels> voxels{};  ///< set of voxels; otherwise null

  bool operator==(const PaintStroke&) const = default;
};

/// Voxels that paint sets in a box of a grid.
struct StrokeVoxels {
  VoxelBox box{};  ///< lies in the grid; empty (size 0) if the stroke sets no voxel
  std::vector<VoxelPaint> voxels;

  /// Calls use(i, j, k, inside) with the index in the grid of each voxel that the stroke sets.
  template <class Use>
  void for_each(const Use& use) const {
    std::size_t v = 0;
    for (int k = 0; k < box.size[2]; ++k)
      for (int j = 0; j < box.size[1]; ++j)
        for (int i = 0; i < box.size[0]; ++i, ++v)
          if (voxels[v] != VoxelPaint::None)
            use(box.first[0] + i, box.first[1] + j, box.first[2] + k, voxels[v] == VoxelPaint::Inside);
  }
};
/// Voxels of a grid that a stroke sets.
/// - Ball: those whose centres are within the radius of the path, and those nearest to a vertex.
/// - Disc: likewise with distances in its slice, and only voxels at most half of the thickness from it (at exactly
///   half: on one side alone).
/// - Contour: those whose centres it encloses (winding number not 0, so that a contour that crosses itself has no
///   holes), at most half of the thickness from its slice.
/// - Set of voxels: those whose centres lie in its voxels.
/// `within`: only voxels of this box.
StrokeVoxels voxels_of(const PaintStroke& stroke, const VolumeGeometry& grid, const VoxelBox& within);
StrokeVoxels voxels_of(const PaintStroke& stroke, const VolumeGeometry& grid);

/// Calls use(i, j, k, inside) with the index of each voxel of a grid that a stroke sets, in unspecified order. Takes
/// less time and memory than voxels_of() for a set with few voxels in a large box.
void for_each_voxel(const PaintStroke& stroke, const VolumeGeometry& grid,
                    const std::function<void(int, int, int, bool)>& use);

/// Sets the voxels of a stroke in a mask to its value.
void apply(const PaintStroke& stroke, Mask& mask);

}  // namespace simplexseg
