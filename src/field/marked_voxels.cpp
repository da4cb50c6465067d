// SPDX-License-Identifier: Apache-2.0
#include "field/marked_voxels.h"

#include <algorithm>
#include <cmath>

#include "core/vec3.h"

namespace simplexseg {
namespace {

PaintedBall painted(const VolumeGeometry& geometry, const VoxelBox& box, const Eigen::Vector3d& centre_mm,
                    double radius_mm, Constraint value) {
  const Eigen::Matrix3d mm = geometry.world_from_index().linear();
  const Eigen::Affine3d index_from_world = geometry.index_from_world();
  const Eigen::Vector3d centre = index_from_world * centre_mm;
  PaintedBall ball;
  ball.radius_mm = radius_mm;
  ball.value = value;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) ball.mm[a][b] = mm(a, b);
    ball.centre[a] = centre[a];
    ball.first[a] = box.first[a];
    // Half of the extent of the ball along this index, from the row of the inverse, and half a voxel.
    const double extent = radius_mm * index_from_world.linear().row(a).norm() + 0.5;
    ball.low[a] = std::max(static_cast<int>(std::ceil(centre[a] - extent)) - box.first[a], 0);
    ball.high[a] = std::min(static_cast<int>(std::floor(centre[a] + extent)) - box.first[a], box.size[a] - 1);
  }
  return ball;
}

}  // namespace

Eigen::Vector3d ball_offset(const Mark& mark) {
  if (mark.kind != MarkKind::Boundary) return Eigen::Vector3d::Zero();
  return mark.radius_mm * mark.outward.normalized();
}

std::vector<PaintedBall> painted_balls(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const Mark> marks,
                                       std::span<const Mark> others) {
  std::vector<PaintedBall> balls;
  balls.reserve(others.size() + 2 * marks.size());
  for (const Mark& other : others)
    balls.push_back(painted(geometry, box, other.position_mm, other.radius_mm, Constraint::OtherObject));
  for (const Mark& mark : marks) {
    const Eigen::Vector3d step = ball_offset(mark);
    if (mark.kind != MarkKind::Outside)
      balls.push_back(painted(geometry, box, mark.position_mm - step, mark.radius_mm, Constraint::Inside));
    if (mark.kind != MarkKind::Inside)
      balls.push_back(painted(geometry, box, mark.position_mm + step, mark.radius_mm, Constraint::Outside));
  }
  return balls;
}

VoxelBox box_around_inside(std::span<const PaintedBall> balls) {
  VoxelBox box{};
  std::array<int, 3> end{};
  for (const PaintedBall& ball : balls) {
    if (ball.value != Constraint::Inside) continue;
    const bool first = box.voxel_count() == 0;
    for (int a = 0; a < 3; ++a) {
      box.first[a] = first ? ball.low[a] : std::min(box.first[a], ball.low[a]);
      end[a] = first ? ball.high[a] + 1 : std::max(end[a], ball.high[a] + 1);
      box.size[a] = std::max(0, end[a] - box.first[a]);
    }
  }
  return box;
}

BoxBoundary::BoxBoundary(const VoxelBox& box, const std::array<int, 3>& volume_size) : size(box.size) {
  for (int a = 0; a < 3; ++a) {
    volume_first[a] = box.first[a] == 0;
    volume_last[a] = box.first[a] + box.size[a] == volume_size[a];
  }
}

}  // namespace simplexseg
