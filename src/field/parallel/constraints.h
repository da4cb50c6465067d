// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "field/box_grid.h"
#include "field/marked_voxels.h"
#include "field/parallel/executor.h"

namespace simplexseg {

/// Balls of all marks, in their order, in the memory of an executor.
struct PaintedBalls {
  const PaintedBall* balls;
  int count;

  /// Constraint of a voxel by the last ball that contains it. `before`: its constraint without marks.
  SIMPLEXSEG_HD Constraint applied_to(Constraint before, const CellAt& p) const {
    for (int b = count - 1; b >= 0; --b) {
      const PaintedBall& ball = balls[b];
      if (p.i < ball.low[0] || p.i > ball.high[0] || p.j < ball.low[1] || p.j > ball.high[1] || p.k < ball.low[2] ||
          p.k > ball.high[2])
        continue;
      if (ball.contains(p.i, p.j, p.k)) return ball.applied_to(before);
    }
    return before;
  }
};

struct ConstraintOfVoxel {
  BoxBoundary boundary;
  PaintedBalls marks;
  const std::uint8_t* finite;
  Constraint* constraints;

  SIMPLEXSEG_HD void operator()(const CellAt& p) const {
    const Constraint before = finite && !finite[p.v] ? Constraint::NotFinite : boundary(p.i, p.j, p.k);
    constraints[p.v] = marks.applied_to(before, p);
  }
};

/// constraint_mask() (field/marked_voxels.h) on an executor, with equal results. In its memory, with a value for each
/// voxel of the box: `finite`, null if all are finite, and `constraints`, which is written.
template <class Executor>
class ConstraintMask {
 public:
  explicit ConstraintMask(const Executor& executor) : executor_(executor) {}

  void find(const VolumeGeometry& geometry, const VoxelBox& box, const std::uint8_t* finite,
            std::span<const Mark> marks, std::span<const Mark> others, Constraint* constraints) {
    const BoxGrid grid{box.size};
    executor_.each_cell(grid, ConstraintOfVoxel{BoxBoundary(box, geometry.size), upload(geometry, box, marks, others),
                                                finite, constraints});
  }
  /// Uploads the balls of the marks, for kernels that apply them to other constraints.
  PaintedBalls upload(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const Mark> marks,
                      std::span<const Mark> others = {}) {
    const std::vector<PaintedBall> balls = painted_balls(geometry, box, marks, others);
    return {balls_.set(executor_, balls), static_cast<int>(balls.size())};
  }
  std::size_t bytes() const { return balls_.bytes(); }

 private:
  const Executor& executor_;
  UploadedList<Executor, PaintedBall> balls_;
};

}  // namespace simplexseg
