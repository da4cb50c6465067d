// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "field/box_grid.h"
#include "field/marked_voxels.h"
#include "field/parallel/executor.h"

namespace simplexseg {

/// Balls of all marks, in their order, in the memory of an executor. A stroke has many, so each plane of the box has a
/// list of the balls that reach it.
struct PaintedBalls {
  const PaintedBall* balls;
  const int* lists;  ///< of plane k: lists[lists[k]] to lists[lists[k + 1] - 1], increasing

  /// Constraint of a voxel by the last ball that contains it. `before`: its constraint without marks.
  SIMPLEXSEG_HD Constraint applied_to(Constraint before, const CellAt& p) const {
    for (int n = lists[p.k + 1] - 1; n >= lists[p.k]; --n) {
      const PaintedBall& ball = balls[lists[n]];
      if (p.i < ball.low[0] || p.i > ball.high[0] || p.j < ball.low[1] || p.j > ball.high[1]) continue;
      if (ball.contains(p.i, p.j, p.k)) return ball.applied_to(before);
    }
    return before;
  }
};

/// Lists of PaintedBalls for a number of planes.
inline std::vector<int> lists_of_planes(std::span<const PaintedBall> balls, int planes) {
  std::vector<std::vector<int>> of_plane(planes);
  for (std::size_t b = 0; b < balls.size(); ++b)
    for (int k = balls[b].low[2]; k <= balls[b].high[2]; ++k) of_plane[k].push_back(static_cast<int>(b));
  std::vector<int> lists(planes + 1);
  for (int k = 0; k < planes; ++k) {
    lists[k] = static_cast<int>(lists.size());
    lists.insert(lists.end(), of_plane[k].begin(), of_plane[k].end());
  }
  lists[planes] = static_cast<int>(lists.size());
  return lists;
}

struct ConstraintOfVoxel {
  BoxBoundary boundary;
  PaintedBalls marks;
  const std::uint8_t *finite, *in_range;  ///< null: 1 for all
  Constraint* constraints;

  SIMPLEXSEG_HD void operator()(const CellAt& p) const {
    const Constraint side = boundary(p.i, p.j, p.k);
    const Constraint before = finite && !finite[p.v]                                   ? Constraint::NotFinite
                              : side == Constraint::None && in_range && !in_range[p.v] ? Constraint::OutOfRange
                                                                                       : side;
    constraints[p.v] = marks.applied_to(before, p);
  }
};

/// constraint_mask() (field/marked_voxels.h) on an executor, with equal results. In its memory, with a value for each
/// voxel of the box: `finite` and `in_range`, null if 1 everywhere, and `constraints`, which is written.
template <class Executor>
class ConstraintMask {
 public:
  explicit ConstraintMask(const Executor& executor) : executor_(executor) {}

  void find(const VolumeGeometry& geometry, const VoxelBox& box, const std::uint8_t* finite,
            const std::uint8_t* in_range, std::span<const Mark> marks, std::span<const Mark> others,
            Constraint* constraints, const BoxSides& open = {}) {
    const BoxGrid grid{box.size};
    executor_.each_cell(grid, ConstraintOfVoxel{BoxBoundary(box, geometry.size, open),
                                                upload(geometry, box, marks, others), finite, in_range, constraints});
  }
  /// Uploads the balls of the marks, for kernels that apply them to other constraints.
  PaintedBalls upload(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const Mark> marks,
                      std::span<const Mark> others = {}) {
    const std::vector<PaintedBall> balls = painted_balls(geometry, box, marks, others);
    return {balls_.set(executor_, balls), lists_.set(executor_, lists_of_planes(balls, box.size[2]))};
  }
  std::size_t bytes() const { return balls_.bytes() + lists_.bytes(); }

 private:
  const Executor& executor_;
  UploadedList<Executor, PaintedBall> balls_;
  UploadedList<Executor, int> lists_;
};

}  // namespace simplexseg
