// SPDX-License-Identifier: Apache-2.0
#include "model/model_start.h"

#include <algorithm>

#include "field/evidence_box.h"
#include "field/robot_user.h"
#include "image/rasterise.h"
#include "model/model_prior.h"
#include "model/template_registration.h"

namespace simplexseg {
namespace {

constexpr double kMarginVoxels = 2;  ///< of the grid around the instance
/// Largest ModelFit::cost. It is below 0.8 for unseen organs, and above 1.2 in regions of other images, to which
/// trust_in() gives some trust because a seed usually excludes them (docs/results/models.md).
constexpr double kMostStartCost = 1.2;

}  // namespace

std::optional<Mark> find_organ(const OrganModel& model, const Volume& volume, const RunJobs& run) {
  if (!has_similar_extent(model.shape.pose, volume.geometry())) return std::nullopt;
  const ModelFit fit = ModelFitter(model, volume, run).fit({});
  if (trust_in(model, fit) == 0 || fit.cost > kMostStartCost) return std::nullopt;
  const std::array<Eigen::Vector3d, 2> bounds{fit.points.rowwise().minCoeff(), fit.points.rowwise().maxCoeff()};
  VolumeGeometry grid = volume.geometry();
  const bool visible = std::ranges::any_of(fit.points.colwise(), [&](const auto& p) { return grid.contains(p); });
  if (!visible) return std::nullopt;
  const VoxelBox box = box_around_bounds(bounds, grid, kMarginVoxels);
  grid.origin_mm = grid.world_from_index() * Eigen::Vector3d(box.first[0], box.first[1], box.first[2]);
  grid.size = box.size;
  const auto deepest = deepest_voxel(rasterise(mesh_at(model.shape.mean, fit.points), grid));
  if (!deepest) return std::nullopt;
  const auto [i, j, k] = deepest->voxel;
  return Mark{MarkKind::Inside, grid.world_from_index() * Eigen::Vector3d(i, j, k), deepest->depth_mm};
}

}  // namespace simplexseg
