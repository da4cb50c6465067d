// SPDX-License-Identifier: Apache-2.0
#include "field/lasso_prompt.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/error.h"
#include "image/plane_contour.h"
#include "image/volume.h"

namespace simplexseg {
namespace {

constexpr double kOutsideVoxels = 2, kOutsideStartVoxels = 5;  // distance of the outside stroke, voxels
constexpr int kMostPlaces = 1500;                              // along a contour
constexpr double kSeedShare = 0.4;  // radius of the seed, relative to its distance from the contour

/// Strokes at a distance from a contour, on its inner or outer side, where no part of the contour is nearer.
std::vector<std::vector<Eigen::Vector3d>> offset_paths(const PlaneContour& contour, bool inwards, double distance_mm,
                                                       double step_mm, const VolumeGeometry& volume) {
  const std::vector<Eigen::Vector2d> places = contour.resampled(step_mm, kMostPlaces);
  const std::size_t count = places.size();
  std::vector<Eigen::Vector3d> moved(count);
  std::vector<char> kept(count);
  for (std::size_t n = 0; n < count; ++n) {
    const Eigen::Vector2d along = places[(n + 1) % count] - places[(n + count - 1) % count];
    if (!(along.norm() > 0)) continue;
    const Eigen::Vector2d across = Eigen::Vector2d(-along[1], along[0]).normalized();
    for (const double side : {1.0, -1.0}) {
      const Eigen::Vector3d at = contour.in_space(places[n] + side * distance_mm * across);
      if (contour.encloses(at) != inwards || contour.is_nearer_than(0.95 * distance_mm, at) || !volume.contains(at))
        continue;
      moved[n] = at, kept[n] = 1;
      break;
    }
  }
  std::vector<std::vector<Eigen::Vector3d>> paths;
  const auto gap = std::ranges::find(kept, 0);
  const bool closed = gap == kept.end();
  const std::size_t start = closed ? 0 : static_cast<std::size_t>(gap - kept.begin());
  bool in_path = false;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t n = (start + k) % count;
    if (!kept[n]) {
      in_path = false;
      continue;
    }
    // Neighbours on different sides of a narrow part are not joined.
    if (!in_path || (moved[n] - paths.back().back()).norm() > 2 * distance_mm + 2 * step_mm) paths.emplace_back();
    paths.back().push_back(moved[n]);
    in_path = true;
  }
  if (closed && paths.size() == 1) paths[0].push_back(paths[0][0]);
  return paths;
}

[[noreturn]] void refuse_empty() {
  throw Error("the lasso", "it encloses nothing of the image", "draw it around a part of the image");
}

PlaneContour contour_of(std::span<const Eigen::Vector3d> contour_mm, const Eigen::Vector3d& normal) {
  if (contour_mm.size() < 3) throw Error("the lasso", "it has fewer than three vertices", "draw around the part");
  return {contour_mm, normal};
}

}  // namespace

std::vector<PromptStroke> prompt_of_lasso(MarkKind kind, std::span<const Eigen::Vector3d> contour_mm,
                                          const Eigen::Vector3d& normal, const VolumeGeometry& volume, bool starts) {
  if (kind == MarkKind::Boundary) throw Error("the lasso", "it is a boundary", "make it inside or outside");
  const PlaneContour contour = contour_of(contour_mm, normal);
  const double voxel_mm = volume.spacing_mm.minCoeff();
  std::vector<PromptStroke> strokes;
  const auto add = [&](MarkKind of, bool inwards, double distance_voxels, double radius_voxels) {
    const std::size_t before = strokes.size();
    for (std::vector<Eigen::Vector3d>& path :
         offset_paths(contour, inwards, distance_voxels * voxel_mm, std::max(radius_voxels, 1.0) * voxel_mm, volume))
      strokes.push_back({of, std::move(path), radius_voxels * voxel_mm});
    return strokes.size() > before;
  };
  if (!add(kind, true, 2, 1) && !add(kind, true, 1, 0.5) && !add(kind, true, 0.5, 0.5)) refuse_empty();
  for (double distance = 6, radius = 2; add(kind, true, distance, radius); radius *= 2) distance += 4 * radius;
  if (kind == MarkKind::Inside) add(MarkKind::Outside, false, starts ? kOutsideStartVoxels : kOutsideVoxels, 1);
  return strokes;
}

Mark seed_of_lasso(std::span<const Eigen::Vector3d> contour_mm, const Eigen::Vector3d& normal,
                   const VolumeGeometry& volume) {
  const PlaneContour contour = contour_of(contour_mm, normal);
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3d& vertex : contour_mm) box.extend(contour.in_plane(vertex));
  Mark seed;
  double depth_mm = 0;
  const auto try_place = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector3d at = contour.in_space(p);
    if (!contour.encloses(at) || !volume.contains(at)) return;
    if (const double mm = contour.distance_mm(at); mm > depth_mm) depth_mm = mm, seed.position_mm = at;
  };
  // Finer grids around the deepest place of the last one.
  constexpr int kSteps = 24, kRounds = 6;
  Eigen::Vector2d centre = box.center(), half = box.sizes() / 2;
  for (int round = 0; round < kRounds; ++round) {
    for (int j = -kSteps; j <= kSteps; ++j)
      for (int i = -kSteps; i <= kSteps; ++i) try_place(centre + Eigen::Vector2d(i, j).cwiseProduct(half) / kSteps);
    if (!(depth_mm > 0)) refuse_empty();
    centre = contour.in_plane(seed.position_mm), half /= 6;
  }
  seed.radius_mm = std::max(kSeedShare * depth_mm, volume.spacing_mm.minCoeff());
  return seed;
}

}  // namespace simplexseg
