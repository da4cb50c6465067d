// SPDX-License-Identifier: Apache-2.0
#include "model/model_prior.h"

#include <algorithm>
#include <cmath>

#include "field/box_image.h"
#include "field/evidence_box.h"
#include "image/distance_map.h"
#include "image/rasterise.h"
#include "model/template_registration.h"

namespace simplexseg {
namespace {

constexpr double kCellsPerError = 2;        ///< cells of the grid per deviation of the surface
constexpr double kLeastProbability = 0.01;  ///< bound of probabilities
constexpr double kSharpness = 3;            ///< factor of the log odds
/// Mean squared Mahalanobis distance per sample of the profiles at which half of the trust remains. It is about 1 where
/// the model fits, and above 2.5 on other organs (docs/results/models.md).
constexpr double kSilentCost = 1.8;
constexpr double kSilentDeviations = 4;     ///< likewise, deviations of the size of the seed
constexpr double kSilentError = 0.15;       ///< likewise, surface_error_mm in sizes of the mean shape
constexpr double kSilentDepths = 0.22;      ///< likewise, surface_error_mm in depths of the organ
constexpr double kLeastTrust = 0.25;        ///< below it there is no prior
constexpr double kLogisticSlope = 1.702;    ///< logistic approximation of the normal distribution
constexpr double kDistanceSmoothing = 0.5;  ///< standard deviation of the Gaussian over signed distances, cells
constexpr double kMarginErrors = 3;         ///< margin of the grid, deviations
constexpr double kLeastMarginVoxels = 4;

/// 1 for small values, 1/2 at `half`, 0 for large ones.
double falling(double value, double half) { return 1 / (1 + std::pow(value / half, 8)); }

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

/// Mean depth of the deepest place of an organ, mm.
double depth_of(const PosePrior& pose) { return std::exp(pose.log_radius.mean + pose.log_scale.mean); }

}  // namespace

double trust_in(const OrganModel& model, const ModelFit& fit) {
  const double trust = falling(fit.cost, kSilentCost) * falling(fit.size_deviations, kSilentDeviations) *
                       falling(model.surface_error_mm / size_of(model.shape), kSilentError) *
                       falling(model.surface_error_mm / depth_of(model.shape.pose), kSilentDepths);
  return trust < kLeastTrust ? 0 : trust;
}

ShapePrior shape_prior_of(const OrganModel& model, const ModelFit& fit, const VolumeGeometry& volume,
                          const RunJobs& run) {
  ShapePrior prior;
  prior.bounds_mm = {fit.points.rowwise().minCoeff(), fit.points.rowwise().maxCoeff()};
  const double error = model.surface_error_mm, margin = kMarginErrors * error;
  CellSize cell = kVoxelCells;
  for (int a = 0; a < 3; ++a) cell[a] = std::max(1.0, error / kCellsPerError / volume.spacing_mm[a]);
  const VolumeGeometry cells = cell_geometry(volume, cell);
  const double least = cells.spacing_mm.minCoeff();
  const VoxelBox box = box_around_bounds(prior.bounds_mm, cells, kLeastMarginVoxels + margin / least);
  prior.grid = cells;
  prior.grid.size = box.size;
  prior.grid.origin_mm = cells.world_from_index() * Eigen::Vector3d(box.first[0], box.first[1], box.first[2]);
  prior.share = trust_in(model, fit);
  const double most = std::log((1 - kLeastProbability) / kLeastProbability);
  prior.log_odds = signed_distances(mesh_at(model.shape.mean, fit.points), prior.grid, run);
  for (float& value : prior.log_odds)
    value = static_cast<float>(kSharpness * prior.share * std::clamp(kLogisticSlope * value / error, -most, most));
  prior.outside = static_cast<float>(-kSharpness * prior.share * most);
  return prior;
}

MakeShapePrior shape_prior_maker(std::shared_ptr<const OrganModel> model, const Volume& volume, const RunJobs& run) {
  auto fitter = std::make_shared<ModelFitter>(*model, volume, run);
  return [fitter, model = std::move(model), &volume, run](std::span<const Mark> marks) {
    const ModelFit fit = fitter->fit(marks);
    if (trust_in(*model, fit) == 0) return std::shared_ptr<const ShapePrior>();
    return std::make_shared<const ShapePrior>(shape_prior_of(*model, fit, volume.geometry(), run));
  };
}

}  // namespace simplexseg
