// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/vec3.h"
#include "field/marks.h"
#include "image/distance_map.h"
#include "image/volume.h"

namespace simplexseg {

/// Constraint of a voxel before the field is solved.
enum class Constraint : std::uint8_t {
  None,
  Inside,
  Outside,
  FarBorder,    ///< side of the box within the volume: outside
  VolumeEdge,   ///< side of the box that is the volume's: outside for the solver, though an object may be cut there
  OtherObject,  ///< in an inside mark of another object: outside for the solver, without effect on the prior
  NotFinite,    ///< conducts nothing; outside
};

/// Whether the field of the voxel is fixed (Dirichlet condition) rather than solved.
constexpr bool is_dirichlet(Constraint constraint) { return constraint != Constraint::None; }

/// Whether the voxel lies in a mark that excludes it from the object: an outside mark, or a mark of another object.
constexpr bool is_excluded(Constraint constraint) {
  return constraint == Constraint::Outside || constraint == Constraint::OtherObject;
}

/// From a boundary mark to its outside ball, mm; its inside ball lies as far on the other side. The two touch at the
/// mark: with a gap between them what a mark says of the layer beside it, which is what was wrong, is little. 0 for
/// other marks.
Eigen::Vector3d ball_offset(const Mark& mark);

/// Constraints of all voxels of a box: later marks replace earlier ones, and marks replace those of `others` (inside
/// marks of other objects) and the sides of the box. `finite`: 0 where the image is not finite; empty: it is
/// finite everywhere. A mark holds the voxels whose centres lie in its ball, and the nearest one.
std::vector<Constraint> constraint_mask(const VolumeGeometry& geometry, const VoxelBox& box,
                                        std::span<const std::uint8_t> finite, std::span<const Mark> marks,
                                        std::span<const Mark> others);

/// Ball of a mark on the grid of a box.
struct PaintedBall {
  double mm[3][3];   ///< of a difference of indices
  double centre[3];  ///< in the box's indices, plus `first`
  double radius_mm;
  int first[3], low[3], high[3];  ///< of the box; the voxels to be asked, in the box
  Constraint value;

  /// Whether the ball holds a voxel of the box between `low` and `high`: its centre lies in it, or it is the nearest.
  SIMPLEXSEG_HD bool holds(int i, int j, int k) const {
    const double x = i + first[0] - centre[0], y = j + first[1] - centre[1], z = k + first[2] - centre[2];
    if (std::fabs(x) <= 0.5 && std::fabs(y) <= 0.5 && std::fabs(z) <= 0.5) return true;
    const double a = mm[0][0] * x + (mm[0][1] * y + mm[0][2] * z), b = mm[1][0] * x + (mm[1][1] * y + mm[1][2] * z),
                 c = mm[2][0] * x + (mm[2][1] * y + mm[2][2] * z);
    return std::sqrt(a * a + (b * b + c * c)) <= radius_mm;
  }
  /// Constraint of a voxel that the ball holds and that had the constraint `at` without it.
  SIMPLEXSEG_HD Constraint over(Constraint at) const {
    if (at == Constraint::NotFinite || (value == Constraint::OtherObject && at != Constraint::None)) return at;
    return value;
  }
};
/// Balls of `others`, then of the marks, in their order.
std::vector<PaintedBall> painted_balls(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const Mark> marks,
                                       std::span<const Mark> others = {});

/// Returns the smallest box, with indices in the box of the balls, that contains all inside balls.
VoxelBox box_around_inside(std::span<const PaintedBall> balls);

/// FarBorder, VolumeEdge or None: what is known of a voxel of a box by where it lies alone.
struct SideOfBox {
  std::array<int, 3> size;                        ///< of the box
  std::array<bool, 3> volume_first, volume_last;  ///< whether the box's sides are the volume's
  SideOfBox(const VoxelBox& box, const std::array<int, 3>& volume_size);

  SIMPLEXSEG_HD Constraint operator()(int i, int j, int k) const {
    const int at[3]{i, j, k};
    bool far = false, edge = false;
    for (int a = 0; a < 3; ++a) {
      if (size[a] < 3) continue;  // else all cells of one or two slices would be constraints
      const bool first = at[a] == 0, last = at[a] == size[a] - 1;
      far |= (first && !volume_first[a]) || (last && !volume_last[a]);
      edge |= (first && volume_first[a]) || (last && volume_last[a]);
    }
    return far ? Constraint::FarBorder : edge ? Constraint::VolumeEdge : Constraint::None;
  }
};

}  // namespace simplexseg
