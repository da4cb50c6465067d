// SPDX-License-Identifier: Apache-2.0
// Prior of the object from a statistical model of its shape.
#pragma once
#include <array>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "field/marks.h"
#include "field/run_jobs.h"
#include "image/volume.h"

namespace simplexseg {

/// Log odds of the object on a grid of the patient frame, added to those of the prior of a field.
struct ShapePrior {
  VolumeGeometry grid;
  std::vector<float> log_odds;  ///< a value for each cell, i fastest
  float outside = 0;            ///< log odds beyond the grid
  double share = 1;             ///< trust in this prior, 0 to 1; contained in the log odds
  /// Corners of the bounding box of the expected object, mm.
  std::array<Eigen::Vector3d, 2> bounds_mm;

  /// Trilinear interpolation at the cells of another grid, i fastest; `outside` beyond the centres of the outermost
  /// cells.
  std::vector<float> at_cells(const VolumeGeometry& cells, const RunJobs& run) const;
};

/// Makes the shape prior for the marks of an update; null: none.
using MakeShapePrior = std::function<std::shared_ptr<const ShapePrior>(std::span<const Mark>)>;

}  // namespace simplexseg
