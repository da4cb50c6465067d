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

/// Constraint of a voxel, set before the field is solved.
enum class Constraint : std::uint8_t {
  None,
  Inside,
  Outside,
  FarBorder,    ///< side of the box beyond which the volume continues: outside
  VolumeEdge,   ///< side of the box that is a side of the volume and not open (cut_sides()): outside for the solver
  OtherObject,  ///< in an inside mark of another object: outside for the solver, without effect on the prior
  NotFinite,    ///< image not finite: no conductance, outside
  OutOfRange,   ///< not in EvidenceSettings::intensity_range: no conductance, outside, without effect on the prior
};

/// Whether the field of the voxel is fixed (Dirichlet condition).
constexpr bool is_dirichlet(Constraint constraint) { return constraint != Constraint::None; }

/// Whether a mark excludes the voxel from the object: an outside mark, or an inside mark of another object.
constexpr bool is_excluded_by_mark(Constraint constraint) {
  return constraint == Constraint::Outside || constraint == Constraint::OtherObject;
}
/// Whether the voxel is excluded from the object by a mark or by the range of intensities. Holes of the second kind are
/// filled.
constexpr bool is_excluded(Constraint constraint) {
  return is_excluded_by_mark(constraint) || constraint == Constraint::OutOfRange;
}

/// Offset from a boundary mark to the centre of its outside ball, mm; the centre of its inside ball has the opposite
/// offset. The balls touch at the mark, so that they constrain the narrow errors beside it. 0 for other marks.
Eigen::Vector3d ball_offset(const Mark& mark);

/// Constraint mask: a value for each voxel of a box. Later marks replace earlier ones, and marks replace those of
/// `others` (inside marks of other objects) and the sides of the box. A mark contains the voxels whose centres are in
/// its ball, and the nearest one. `finite`: 0 where the image is not finite; empty if it is finite everywhere.
/// `in_range`: 0 for voxels out of range; empty if there are none.
std::vector<Constraint> constraint_mask(const VolumeGeometry& geometry, const VoxelBox& box,
                                        std::span<const std::uint8_t> finite, std::span<const Mark> marks,
                                        std::span<const Mark> others, std::span<const std::uint8_t> in_range = {});

/// Ball of a mark on the grid of a box.
struct PaintedBall {
  double mm[3][3];   ///< from a difference of indices to mm
  double centre[3];  ///< index in the volume
  double radius_mm;
  int first[3];         ///< first voxel of the box
  int low[3], high[3];  ///< range of the voxels to test, both included, indices in the box
  Constraint value;

  /// Whether the ball contains a voxel of the box between `low` and `high`: its centre, or it is the nearest voxel.
  SIMPLEXSEG_HD bool contains(int i, int j, int k) const {
    const double x = i + first[0] - centre[0], y = j + first[1] - centre[1], z = k + first[2] - centre[2];
    if (std::fabs(x) <= 0.5 && std::fabs(y) <= 0.5 && std::fabs(z) <= 0.5) return true;
    const double a = mm[0][0] * x + (mm[0][1] * y + mm[0][2] * z), b = mm[1][0] * x + (mm[1][1] * y + mm[1][2] * z),
                 c = mm[2][0] * x + (mm[2][1] * y + mm[2][2] * z);
    return std::sqrt(a * a + (b * b + c * c)) <= radius_mm;
  }
  /// Constraint of a voxel that the ball contains. `before`: its constraint without the ball.
  SIMPLEXSEG_HD Constraint applied_to(Constraint before) const {
    const bool is_free = before == Constraint::None || before == Constraint::OutOfRange;
    if (before == Constraint::NotFinite || (value == Constraint::OtherObject && !is_free)) return before;
    return value;
  }
};
/// Balls of `others`, then balls of the marks, in their order.
std::vector<PaintedBall> painted_balls(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const Mark> marks,
                                       std::span<const Mark> others = {});

/// Bounding box of all inside balls, with indices in the box of the balls.
VoxelBox box_around_inside(std::span<const PaintedBall> balls);

/// Some of the six sides of a box: the first and the last one along each axis.
struct BoxSides {
  std::array<bool, 3> first{}, last{};
  bool operator==(const BoxSides&) const = default;
  bool any() const { return *this != BoxSides{}; }
};

/// Constraint of a voxel by its position in the box: FarBorder, VolumeEdge or None.
struct BoxBoundary {
  std::array<int, 3> size;                ///< of the box
  std::array<Constraint, 3> first, last;  ///< of the voxels of each side
  /// `open`: sides of the volume through which the object continues; they have no constraint.
  BoxBoundary(const VoxelBox& box, const std::array<int, 3>& volume_size, const BoxSides& open = {});

  SIMPLEXSEG_HD Constraint operator()(int i, int j, int k) const {
    const int at[3]{i, j, k};
    bool far = false, edge = false;
    for (int a = 0; a < 3; ++a) {
      if (size[a] < 3) continue;  // else all cells of one or two slices would be constraints
      const Constraint low = at[a] == 0 ? first[a] : Constraint::None,
                       high = at[a] == size[a] - 1 ? last[a] : Constraint::None;
      far |= low == Constraint::FarBorder || high == Constraint::FarBorder;
      edge |= low == Constraint::VolumeEdge || high == Constraint::VolumeEdge;
    }
    return far ? Constraint::FarBorder : edge ? Constraint::VolumeEdge : Constraint::None;
  }
};

}  // namespace simplexseg
