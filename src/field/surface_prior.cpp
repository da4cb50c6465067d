// SPDX-License-Identifier: Apache-2.0
#include "field/surface_prior.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "field/box_image.h"
#include "field/evidence_box.h"
#include "image/distance_map.h"
#include "image/rasterise.h"

namespace simplexseg {
namespace {

constexpr double kCellsPerError = 2;        ///< cells of the grid per deviation of the surface
constexpr double kLeastProbability = 0.01;  ///< bound of probabilities
constexpr double kLogisticSlope = 1.702;    ///< logistic approximation of the normal distribution
constexpr double kDistanceSmoothing = 0.5;  ///< standard deviation of the Gaussian over signed distances, cells
constexpr double kMarginErrors = 3;         ///< margin of the grid, deviations
constexpr double kLeastMarginVoxels = 4;
/// Factor of the log odds of a surface of an earlier study. Measured: docs/results/follow-up.md.
constexpr double kEarlierStrength = 2;

/// Distance of the cells of a grid from a surface, mm, positive inside; exact to a fraction of a cell near the surface.
std::vector<float> signed_distances(const SimplexMesh& mesh, const VolumeGeometry& grid, const RunJobs& run) {
  const std::vector<float> fractions = inside_fractions(mesh, grid);
  const VoxelBox box{{0, 0, 0}, grid.size};
  const Eigen::Matrix3d mm = grid.world_from_index().linear();
  std::vector<std::uint8_t> set(fractions.size());
  std::vector<float> distances(fractions.size());
  const auto half = static_cast<float>(0.5 * grid.spacing_mm.minCoeff());
  for (const bool inside : {true, false}) {  // distances of the cells on this side to the other side
    for (std::size_t v = 0; v < set.size(); ++v) set[v] = (fractions[v] > 0.5f) != inside;
    const std::vector<float> to = distance_map(set, box, mm);
    for (std::size_t v = 0; v < set.size(); ++v)
      if (!set[v]) distances[v] = (inside ? 1.0f : -1.0f) * (std::min(to[v], 1e6f) - half);
  }
  smooth(distances, BoxGrid{box.size}, {kDistanceSmoothing, kDistanceSmoothing, kDistanceSmoothing}, run);
  return distances;
}

}  // namespace

ShapePrior surface_prior(const SimplexMesh& surface, double error_mm, double strength, const VolumeGeometry& volume,
                         const RunJobs& run) {
  ShapePrior prior;
  Eigen::AlignedBox3f bounds;
  for (const Eigen::Vector3f& p : surface.positions) bounds.extend(p);
  prior.bounds_mm = {bounds.min().cast<double>(), bounds.max().cast<double>()};
  CellSize cell = kVoxelCells;
  for (int a = 0; a < 3; ++a) cell[a] = std::max(1.0, error_mm / kCellsPerError / volume.spacing_mm[a]);
  const VolumeGeometry cells = cell_geometry(volume, cell);
  const double least = cells.spacing_mm.minCoeff();
  const VoxelBox box = box_around_bounds(prior.bounds_mm, cells, kLeastMarginVoxels + kMarginErrors * error_mm / least);
  prior.grid = cells;
  prior.grid.size = box.size;
  prior.grid.origin_mm = cells.world_from_index() * Eigen::Vector3d(box.first[0], box.first[1], box.first[2]);
  const double most = std::log((1 - kLeastProbability) / kLeastProbability);
  prior.log_odds = signed_distances(surface, prior.grid, run);
  for (float& value : prior.log_odds)
    value = static_cast<float>(strength * std::clamp(kLogisticSlope * value / error_mm, -most, most));
  prior.outside = static_cast<float>(-strength * most);
  return prior;
}

MakeShapePrior surface_prior_maker(std::shared_ptr<const SimplexMesh> surface, double error_mm,
                                   const VolumeGeometry& volume, const RunJobs& run) {
  return [surface = std::move(surface), error_mm, volume, run,
          made = std::shared_ptr<const ShapePrior>()](std::span<const Mark>) mutable {
    if (!made)
      made = std::make_shared<const ShapePrior>(surface_prior(*surface, error_mm, kEarlierStrength, volume, run));
    return made;
  };
}

}  // namespace simplexseg
