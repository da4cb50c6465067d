// SPDX-License-Identifier: Apache-2.0
#include "field/robot_stroke.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "field/slice_region.h"

namespace simplexseg {
namespace {

constexpr double kJitterVoxels = 0.5;    // largest deviation of the hand, voxels
constexpr int kJitterStep = 3;           // distance of the points at which the hand deviates, voxels of the path
constexpr double kBoxNoiseVoxels = 1;    // largest deviation of the side of a box, voxels
constexpr double kLateStopVoxels = 1.5;  // largest length by which the hand stops too late, voxels

/// Voxels of an error in a slice. `axis`: index axis perpendicular to the slice.
SliceRegion error_in_slice(const Mask& truth, const Mask& now, const WorstError& error, int axis) {
  return {truth.geometry, error.voxel, axis, [&](std::size_t v) {
            return truth.voxels[v] != now.voxels[v] && (truth.voxels[v] != 0) == error.too_little;
          }};
}

/// Slice through the deepest voxel of an error that shows most of it.
SliceRegion largest_slice(const Mask& truth, const Mask& now, const WorstError& error) {
  std::optional<SliceRegion> slice;
  for (int axis = 2; axis >= 0; --axis) {
    SliceRegion other = error_in_slice(truth, now, error, axis);
    if (!slice || other.area_mm2() > slice->area_mm2()) slice.emplace(std::move(other));
  }
  return *std::move(slice);
}

/// Uniform number between -1 and 1, the same with every standard library.
double noise(std::mt19937& generator) { return 2 * (generator() / 4294967295.0) - 1; }

}  // namespace

std::optional<RobotLasso> lasso_at_error(const Mask& truth, const Mask& now, const WorstError& error, int lasso) {
  constexpr std::size_t kLeastVoxels = 4;
  require_same_grid(truth, now);
  const int axis = largest_slice(truth, now, error).axis();
  const Mask nothing{truth.geometry, std::vector<std::uint8_t>(truth.voxels.size())};
  const SliceRegion enclosed = error_in_slice(truth, error.too_little ? nothing : now, error, axis);
  if (enclosed.voxel_count() < kLeastVoxels) return std::nullopt;
  const std::vector<Eigen::Vector2d> outline = enclosed.outline();
  std::mt19937 generator(static_cast<std::uint32_t>(lasso));
  RobotLasso drawn{error.too_little ? MarkKind::Inside : MarkKind::Outside, {}, {}};
  for (std::size_t p = 0; p < outline.size(); p += kJitterStep) {
    const double a = outline[p][0] + kJitterVoxels * noise(generator);
    const double b = outline[p][1] + kJitterVoxels * noise(generator);
    drawn.contour_mm.push_back(enclosed.place(a, b));
  }
  drawn.normal = enclosed.normal();
  return drawn;
}

BoxCorners box_around_object(const Mask& object, const WorstError& deepest) {
  const Mask nothing{object.geometry, std::vector<std::uint8_t>(object.voxels.size())};
  const SliceRegion slice = largest_slice(object, nothing, deepest);
  std::mt19937 generator(0);
  double side[2][2];
  for (int x = 0; x < 2; ++x)
    for (int end = 0; end < 2; ++end)
      side[x][end] = slice.bounds()[x][end] + (end == 0 ? -0.5 : 0.5) + kBoxNoiseVoxels * noise(generator);
  return {slice.place(side[0][0], side[1][0]), slice.place(side[0][1], side[1][0]), slice.place(side[0][1], side[1][1]),
          slice.place(side[0][0], side[1][1])};
}

std::vector<Eigen::Vector3d> stroke_in_error(const Mask& truth, const Mask& now, const WorstError& error, int stroke) {
  require_same_grid(truth, now);
  SliceRegion slice = largest_slice(truth, now, error);
  const std::vector<Eigen::Vector3d> middle = slice.middle();
  const Eigen::Matrix<double, 3, 2> axes = slice.axes();
  std::mt19937 generator(static_cast<std::uint32_t>(stroke));
  std::vector<Eigen::Vector3d> path;
  for (std::size_t p = 0; p < middle.size(); p += kJitterStep) {
    const Eigen::Vector2d deviation(noise(generator), noise(generator));
    path.emplace_back(middle[p] + kJitterVoxels * axes * deviation);
  }
  if (middle.size() > 1) {
    const double late = kLateStopVoxels * std::abs(noise(generator));
    const Eigen::Vector3d along = (middle.back() - middle[middle.size() - 2]).normalized();
    path.emplace_back(middle.back() + late * truth.geometry.spacing_mm.minCoeff() * along);
  }
  std::erase_if(path, [&](const Eigen::Vector3d& mm) { return !truth.geometry.contains(mm); });
  if (path.empty()) path.push_back(middle.front());
  return path;
}

}  // namespace simplexseg
