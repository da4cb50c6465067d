// SPDX-License-Identifier: Apache-2.0
// Changes of the field far from new marks (docs/adr/0043-changes-far-from-marks.md).
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "field/field_solver.h"
#include "field/field_voxel.h"
#include "field/marked_voxels.h"
#include "field/parallel/executor.h"

namespace simplexseg {

/// Ball of a new mark, in mm from the first cell of the box along its axes.
struct NewMarkDepth {
  float at_mm[3];
  float depth_mm;
};

/// Reduces the change of a cell since the previous field where it is far from all new marks.
struct DampFarChange {
  const NewMarkDepth* marks;
  int count;
  float mm[3];       ///< spacing of cells
  float far_depths;  ///< depths from a mark at which half of the reduction applies, from 2/3 to 4/3 of it
  float share;       ///< of the change that remains far away; 0: also of unknown cells, which are background
  const std::uint8_t* previous;  ///< previous field, 1..255 for 0..1, 0: unknown
  const Constraint* constraints;
  float* field;

  /// Least distance to a new mark, in its depths.
  SIMPLEXSEG_HD float depths_away(const CellAt& at) const {
    float least = 1e12f;
    for (int m = 0; m < count; ++m) {
      const NewMarkDepth& mark = marks[m];
      const float x = static_cast<float>(at.i) * mm[0] - mark.at_mm[0],
                  y = static_cast<float>(at.j) * mm[1] - mark.at_mm[1],
                  z = static_cast<float>(at.k) * mm[2] - mark.at_mm[2];
      least = smaller((x * x + y * y + z * z) / (mark.depth_mm * mark.depth_mm), least);
    }
    return std::sqrt(least);
  }
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    const int v = at.v;
    if ((previous[v] == 0 && share > 0) || constraints[v] == Constraint::Inside || is_excluded(constraints[v])) return;
    const float away = smaller(larger(1.5f * depths_away(at) / far_depths - 1, 0.0f), 1.0f);
    const float old = previous[v] == 0 ? 0.0f : from_8_bits(previous[v]);
    field[v] = old + (1 - away * (1 - share)) * (field[v] - old);
  }
};

/// New marks for DampFarChange, in a box of `cells`. A depth is at least one cell.
inline std::vector<NewMarkDepth> depths_of(std::span<const NewMarkBall> marks, const VolumeGeometry& cells,
                                           const VoxelBox& box) {
  const Eigen::Affine3d index = cells.index_from_world();
  std::vector<NewMarkDepth> depths;
  for (const NewMarkBall& mark : marks) {
    const Eigen::Vector3d at = index * mark.centre_mm;
    NewMarkDepth& depth = depths.emplace_back();
    for (int a = 0; a < 3; ++a) depth.at_mm[a] = static_cast<float>((at[a] - box.first[a]) * cells.spacing_mm[a]);
    depth.depth_mm = static_cast<float>(std::max(mark.depth_mm, cells.spacing_mm.minCoeff()));
  }
  return depths;
}

}  // namespace simplexseg
