// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "field/box_grid.h"
#include "field/marked_voxels.h"
#include "field/parallel/executor.h"

namespace simplexseg {

/// The balls of all marks, in their order, in the executor's memory.
struct PaintedBalls {
  const PaintedBall* balls;
  int count;

  /// What is known of a voxel of the box, `at` being what was known of it without marks: the last ball that holds it.
  SIMPLEXSEG_HD Constraint over(Constraint at, const CellAt& p) const {
    for (int b = count - 1; b >= 0; --b) {
      const PaintedBall& ball = balls[b];
      if (p.i < ball.low[0] || p.i > ball.high[0] || p.j < ball.low[1] || p.j > ball.high[1] || p.k < ball.low[2] ||
          p.k > ball.high[2])
        continue;
      if (ball.holds(p.i, p.j, p.k)) return ball.over(at);
    }
    return at;
  }
};

struct KnownOfVoxel {
  SideOfBox side;
  PaintedBalls marks;
  const std::uint8_t* finite;
  Constraint* known;

  SIMPLEXSEG_HD void operator()(const CellAt& p) const {
    const int v = p.v;
    const Constraint at = finite && !finite[v] ? Constraint::NotFinite : side(p.i, p.j, p.k);
    known[v] = marks.over(at, p);
  }
};

/// constraint_mask() (field/marked_voxels.h) on an executor, the same for every voxel. In the executor's memory, a
/// value for each voxel of the box: `finite`, or null, and `known`, which is written.
template <class Executor>
class ConstraintVoxels {
 public:
  explicit ConstraintVoxels(const Executor& executor) : executor_(executor) {}

  void find(const VolumeGeometry& geometry, const VoxelBox& box, const std::uint8_t* finite,
            std::span<const Mark> marks, std::span<const Mark> others, Constraint* known) {
    const BoxGrid grid{box.size};
    executor_.each_cell(
        grid, KnownOfVoxel{SideOfBox(box, geometry.size), upload(geometry, box, marks, others), finite, known});
  }
  /// The balls of the marks, for kernels that paint them over other constraints.
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
