// SPDX-License-Identifier: Apache-2.0
#include "field/seed_scale.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <vector>

#include "field/quantile.h"

namespace simplexseg {
namespace {

constexpr int kRays = 240;
constexpr double kInner = 0.6;                               // of the radius: what the ball is like
constexpr double kFarthest = 3, kMost = 2;                   // radii: of a ray; of the result
constexpr double kLeastStepVoxels = 0.25, kLeastSteps = 24;  // of a ray; steps of a radius
constexpr double kSmoothingVoxels = 0.7;
constexpr double kNearest = 0.2;  // share of the rays
constexpr std::array kDeviations{4.0, 6.0};
constexpr double kLeastWallDeviation = 0.01;  // of the range of all that the rays meet
constexpr double kSameWall = 1.4;             // largest ratio of the distances for the two
constexpr double kClear = 1.3;                // radii: a nearer wall may be the ball's own
constexpr double kCare = 0.93;                // of the distance: too small a ball costs less than too large a one

/// The image along rays out of a place, evenly over the sphere.
struct Rays {
  int steps;
  std::vector<double> met;  ///< ray by ray

  Rays(const Volume& volume, const Eigen::Vector3d& centre_mm, double step_mm, int count)
      : steps(count), met(static_cast<std::size_t>(kRays) * count) {
    const double aside = kSmoothingVoxels * volume.geometry().spacing_mm.minCoeff();
    std::size_t at = 0;
    for (int ray = 0; ray < kRays; ++ray) {  // a spiral of golden angles
      const double z = 1 - (2 * ray + 1.0) / kRays, turn = ray * std::numbers::pi * (3 - std::sqrt(5.0));
      const Eigen::Vector3d way(std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z);
      for (int s = 0; s < steps; ++s) {
        const Eigen::Vector3d mm = centre_mm + s * step_mm * way;
        double sum = volume.sample(mm);
        for (int a = 0; a < 3; ++a)
          for (const double o : {-aside, aside}) sum += volume.sample(mm + o * Eigen::Vector3d::Unit(a));
        met[at++] = sum / 7;
      }
    }
  }

  /// Of the nearest rays the farthest distance, in steps, to what differs from `middle` by more.
  int wall(double middle, double difference) const {
    std::vector<double> first(kRays);
    for (int ray = 0; ray < kRays; ++ray) {
      int s = 0;
      while (s < steps && std::fabs(met[static_cast<std::size_t>(ray) * steps + s] - middle) <= difference) ++s;
      first[ray] = s;  // what is not finite does not differ by less
    }
    return static_cast<int>(quantile(first, kNearest));
  }
};

}  // namespace

SeedScale seed_scale(const Volume& volume, const Eigen::Vector3d& centre_mm, double radius_mm) {
  const double step = std::max(kLeastStepVoxels * volume.geometry().spacing_mm.minCoeff(), radius_mm / kLeastSteps);
  const Rays rays(volume, centre_mm, step, std::max(1, static_cast<int>(kFarthest * radius_mm / step)));
  std::vector<double> finite, inner;
  for (std::size_t m = 0; m < rays.met.size(); ++m) {
    if (!std::isfinite(rays.met[m])) continue;
    finite.push_back(rays.met[m]);
    if (static_cast<double>(m % rays.steps) * step <= kInner * radius_mm) inner.push_back(rays.met[m]);
  }
  if (inner.empty()) return {radius_mm, false};
  const double middle = quantile(inner, 0.5);
  for (double& x : inner) x = std::fabs(x - middle);
  const double range = quantile(finite, 0.99) - quantile(finite, 0.01);
  const double deviation = std::max(kDeviationsOfMedian * quantile(inner, 0.5), kLeastWallDeviation * range);
  std::array<double, 2> radii;
  for (std::size_t k = 0; k < radii.size(); ++k)
    radii[k] = rays.wall(middle, kDeviations[k] * deviation) * step / radius_mm;
  if (radii[1] > kSameWall * radii[0] || radii[1] > 0.95 * kFarthest) return {radius_mm, false};
  const double reach = kCare * std::sqrt(radii[0] * radii[1]);
  return {reach < kClear ? radius_mm : std::min(reach, kMost) * radius_mm, true};
}

}  // namespace simplexseg
