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

/// Deepest voxel of an instance, with its depth as radius; nothing outside the volume.
std::optional<Mark> seed_of(const ShapeModel& shape, const Eigen::Matrix3Xd& points, VolumeGeometry grid) {
  const std::array<Eigen::Vector3d, 2> bounds{points.rowwise().minCoeff(), points.rowwise().maxCoeff()};
  if (std::ranges::none_of(points.colwise(), [&](const auto& p) { return grid.contains(p); })) return std::nullopt;
  const VoxelBox box = box_around_bounds(bounds, grid, kMarginVoxels);
  grid.origin_mm = grid.world_from_index() * Eigen::Vector3d(box.first[0], box.first[1], box.first[2]);
  grid.size = box.size;
  const auto deepest = deepest_voxel(rasterise(mesh_at(shape.mean, points), grid));
  if (!deepest) return std::nullopt;
  const auto [i, j, k] = deepest->voxel;
  return Mark{MarkKind::Inside, grid.world_from_index() * Eigen::Vector3d(i, j, k), deepest->depth_mm};
}

/// Instance of an organ at its mean place relative to the volume; nothing if it is not recognised.
std::optional<ModelFit> unprompted_fit(const OrganModel& model, const Volume& volume, const RunJobs& run) {
  if (!has_similar_extent(model.shape.pose, volume.geometry())) return std::nullopt;
  ModelFit fit = ModelFitter(model, volume, run).fit({});
  if (trust_in(model, fit) == 0 || fit.cost > kMostStartCost) return std::nullopt;
  return fit;
}

/// Whether a place is on the inner side of a surface, at its nearest vertex.
bool contains_place(const ShapeModel& shape, const Eigen::Matrix3Xd& points, const Eigen::Vector3d& place) {
  Eigen::Index v = 0;
  (points.colwise() - place).colwise().squaredNorm().minCoeff(&v);
  return normals_of(shape.mean.neighbours, points).col(v).dot(place - points.col(v)) < 0;
}

/// Search for the organs of a model in an image.
class OrganSearch {
 public:
  OrganSearch(const std::vector<OrganModel>& organs, const PoseRelations& relations, const Volume& volume,
              const RunJobs& run)
      : organs_(organs),
        relations_(relations),
        volume_(volume),
        run_(run),
        poses_(organs.size()),
        seeds_(organs.size()),
        searched_(organs.size(), false) {}

  void add(FoundOrgan one) {
    searched_[one.organ] = true;
    poses_[one.organ] = pose_of(organs_[one.organ].shape, one.points);
    seeds_[one.organ] = seed_of(organs_[one.organ].shape, one.points, volume_.geometry());
    found_.push_back(std::move(one));
  }

  /// Adds the organ that is found at its place in the volume with the least cost.
  void find_first() {
    std::optional<FoundSeed> best;
    Eigen::Matrix3Xd points;
    for (int organ = 0; organ < std::ssize(organs_); ++organ) {
      const std::optional<ModelFit> fit = unprompted_fit(organs_[organ], volume_, run_);
      if (!fit || (best && best->cost <= fit->cost)) continue;
      const std::optional<Mark> seed = seed_of(organs_[organ].shape, fit->points, volume_.geometry());
      if (!seed) continue;
      best = {organ, *seed, fit->cost};
      points = fit->points;
    }
    if (!best) return;
    add({best->organ, std::move(points)});
    results_.push_back(*best);
  }

  /// Searches for the organ whose place is most certain. Returns whether one was left.
  bool find_next() {
    int next = -1;
    std::optional<PoseDistribution> expected;
    for (int organ = 0; organ < std::ssize(organs_); ++organ) {
      if (searched_[organ]) continue;
      const auto one = expected_pose(relations_, organs_, poses_, organ);
      const auto variance = [](const PoseDistribution& d) { return d.covariance.diagonal().tail<3>().sum(); };
      if (!one || (expected && variance(*expected) <= variance(*one))) continue;
      next = organ, expected = one;
    }
    if (!expected) return false;
    searched_[next] = true;
    const OrganModel& model = organs_[next];
    const std::optional<ModelFit> fit = ModelFitter(model, volume_, run_).fit_at(*expected);
    if (!fit || trust_in(model, *fit) == 0) return true;
    const std::optional<Mark> seed = seed_of(model.shape, fit->points, volume_.geometry());
    if (!seed || overlaps_found(next, *fit, *seed)) return true;
    add({next, fit->points});
    results_.push_back({next, *seed, fit->cost});
    return true;
  }

  std::vector<FoundSeed> results() const { return results_; }

 private:
  bool overlaps_found(int organ, const ModelFit& fit, const Mark& seed) const {
    return std::ranges::any_of(found_, [&](const FoundOrgan& other) {
      return contains_place(organs_[other.organ].shape, other.points, seed.position_mm) ||
             (seeds_[other.organ] &&
              contains_place(organs_[organ].shape, fit.points, seeds_[other.organ]->position_mm));
    });
  }

  const std::vector<OrganModel>& organs_;
  const PoseRelations& relations_;
  const Volume& volume_;
  const RunJobs& run_;
  std::vector<std::optional<PoseVector>> poses_;  // of found organs
  std::vector<std::optional<Mark>> seeds_;
  std::vector<bool> searched_;
  std::vector<FoundOrgan> found_;
  std::vector<FoundSeed> results_;
};

}  // namespace

std::optional<Mark> find_organ(const OrganModel& model, const Volume& volume, const RunJobs& run) {
  const std::optional<ModelFit> fit = unprompted_fit(model, volume, run);
  return fit ? seed_of(model.shape, fit->points, volume.geometry()) : std::nullopt;
}

std::vector<FoundSeed> find_organs(const std::vector<OrganModel>& organs, const PoseRelations& relations,
                                   const Volume& volume, std::vector<FoundOrgan> found, const std::vector<int>& wanted,
                                   const RunJobs& run) {
  OrganSearch search(organs, relations, volume, run);
  for (FoundOrgan& one : found) search.add(std::move(one));
  if (found.empty()) search.find_first();
  while (search.find_next()) {
  }
  std::vector<FoundSeed> results = search.results();
  std::erase_if(results, [&](const FoundSeed& one) { return std::ranges::find(wanted, one.organ) == wanted.end(); });
  std::ranges::sort(results, {}, &FoundSeed::organ);
  return results;
}

}  // namespace simplexseg
