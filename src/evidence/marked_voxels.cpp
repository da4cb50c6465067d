// SPDX-License-Identifier: Apache-2.0
#include "evidence/marked_voxels.h"

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
    // A ball in mm reaches this far along each index: the rows of the inverse say how fast an index changes.
    const double reach = radius_mm * index_from_world.linear().row(a).norm() + 0.5;
    ball.low[a] = std::max(static_cast<int>(std::ceil(centre[a] - reach)) - box.first[a], 0);
    ball.high[a] = std::min(static_cast<int>(std::floor(centre[a] + reach)) - box.first[a], box.size[a] - 1);
  }
  return ball;
}

}  // namespace

Eigen::Vector3d ball_offset(const Mark& mark) {
  if (mark.kind != MarkKind::Boundary) return Eigen::Vector3d::Zero();
  return mark.radius_mm * mark.outward.normalized();
}

std::vector<Constraint> constraint_mask(const VolumeGeometry& geometry, const VoxelBox& box,
                                        std::span<const std::uint8_t> finite, std::span<const Mark> marks,
                                        std::span<const Mark> others) {
  std::vector<Constraint> known(box.voxel_count(), Constraint::None);
  const SideOfBox side(box, geometry.size);
  for (int k = 0; k < box.size[2]; ++k) {
    for (int j = 0; j < box.size[1]; ++j) {
      const std::size_t row = box.offset(0, j, k);
      const bool at_side = j == 0 || k == 0 || j == box.size[1] - 1 || k == box.size[2] - 1;
      for (int i = 0; i < box.size[0]; i += at_side ? 1 : std::max(1, box.size[0] - 1)) known[row + i] = side(i, j, k);
    }
  }
  for (std::size_t v = 0; v < finite.size(); ++v)
    if (!finite[v]) known[v] = Constraint::NotFinite;
  paint_marks(geometry, box, marks, known, others);
  return known;
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

SideOfBox::SideOfBox(const VoxelBox& box, const std::array<int, 3>& volume_size) : size(box.size) {
  for (int a = 0; a < 3; ++a) {
    volume_first[a] = box.first[a] == 0;
    volume_last[a] = box.first[a] + box.size[a] == volume_size[a];
  }
}

void paint_marks(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const Mark> marks,
                 std::vector<Constraint>& known, std::span<const Mark> others) {
  for (const PaintedBall& ball : painted_balls(geometry, box, marks, others)) {
    for (int k = ball.low[2]; k <= ball.high[2]; ++k) {
      for (int j = ball.low[1]; j <= ball.high[1]; ++j) {
        for (int i = ball.low[0]; i <= ball.high[0]; ++i) {
          Constraint& at = known[box.offset(i, j, k)];
          if (ball.holds(i, j, k)) at = ball.over(at);
        }
      }
    }
  }
}

std::vector<float> squared_distances(const VolumeGeometry& geometry, const VoxelBox& box,
                                     std::span<const Eigen::Vector3d> places_mm, const RunJobs& run) {
  std::vector<float> distance(box.voxel_count(), 1e12f);
  const Eigen::Affine3d world = geometry.world_from_index();
  const Eigen::Vector3d step = world.linear().col(0);
  const float step2 = static_cast<float>(step.squaredNorm());
  run(box.size[2], [&](int k) {
    for (int j = 0; j < box.size[1]; ++j) {
      float* const row = distance.data() + box.offset(0, j, k);
      const Eigen::Vector3d start = world * Eigen::Vector3d(box.first[0], j + box.first[1], k + box.first[2]);
      for (const Eigen::Vector3d& place : places_mm) {
        const Eigen::Vector3d from = start - place;
        const float square = static_cast<float>(from.squaredNorm()), twice = static_cast<float>(2 * from.dot(step));
        for (int i = 0; i < box.size[0]; ++i) {
          const float t = static_cast<float>(i);
          row[i] = smaller(larger(square + t * (twice + t * step2), 0.0f), row[i]);
        }
      }
    }
  });
  return distance;
}

}  // namespace simplexseg
