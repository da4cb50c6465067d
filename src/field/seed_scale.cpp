// SPDX-License-Identifier: Apache-2.0
#include "field/seed_scale.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <vector>

#include "core/quantile.h"

namespace simplexseg {
namespace {

constexpr int kRays = 240;
constexpr double kInner = 0.6;                               // radius of the interior of the ball, radii
constexpr double kFarthest = 3, kMost = 2;                   // length of a ray, largest scale, radii
constexpr double kLeastStepVoxels = 0.25, kLeastSteps = 24;  // least step, voxels; least number of steps per radius
constexpr double kSmoothingVoxels = 0.7;                     // distance of the further samples
constexpr double kNearest = 0.2;                             // quantile over the rays
constexpr std::array kDeviations{4.0, 6.0};                  // standard deviations of an edge
constexpr double kLeastEdgeDeviation = 0.01;                 // least standard deviation, of the range of all samples
constexpr double kLargestRatio = 1.4;                        // of the distances for the two values of kDeviations
constexpr double kLeastRatio = 1.3;     // least scale, radii; nearer edges may be those of the ball
constexpr double kSafetyFactor = 0.93;  // on the distance; too small scales are better than too large ones

/// Samples of the image along rays from a place, which are distributed evenly over the sphere.
struct Rays {
  int steps;
  std::vector<double> values;  ///< kRays x steps

  Rays(const Volume& volume, const Eigen::Vector3d& centre_mm, double step_mm, int count)
      : steps(count), values(static_cast<std::size_t>(kRays) * count) {
    const double offset = kSmoothingVoxels * volume.geometry().spacing_mm.minCoeff();
    std::size_t at = 0;
    for (int ray = 0; ray < kRays; ++ray) {  // spiral with the golden angle
      const double z = 1 - (2 * ray + 1.0) / kRays, turn = ray * std::numbers::pi * (3 - std::sqrt(5.0));
      const Eigen::Vector3d direction(std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z);
      for (int s = 0; s < steps; ++s) {
        const Eigen::Vector3d mm = centre_mm + s * step_mm * direction;
        double sum = volume.sample(mm);
        for (int a = 0; a < 3; ++a)
          for (const double o : {-offset, offset}) sum += volume.sample(mm + o * Eigen::Vector3d::Unit(a));
        values[at++] = sum / 7;
      }
    }
  }

  /// Quantile kNearest over the rays of the distance to the first sample that differs by more from `median`, steps.
  int edge_distance(double median, double difference) const {
    std::vector<double> first(kRays);
    for (int ray = 0; ray < kRays; ++ray) {
      int s = 0;
      while (s < steps && std::fabs(values[static_cast<std::size_t>(ray) * steps + s] - median) <= difference) ++s;
      first[ray] = s;  // also for a sample that is not finite
    }
    return static_cast<int>(quantile(first, kNearest));
  }
};

}  // namespace

SeedScale seed_scale(const Volume& volume, const Eigen::Vector3d& centre_mm, double radius_mm) {
  const double step = std::max(kLeastStepVoxels * volume.geometry().spacing_mm.minCoeff(), radius_mm / kLeastSteps);
  const Rays rays(volume, centre_mm, step, std::max(1, static_cast<int>(kFarthest * radius_mm / step)));
  std::vector<double> finite, inner;
  for (std::size_t m = 0; m < rays.values.size(); ++m) {
    if (!std::isfinite(rays.values[m])) continue;
    finite.push_back(rays.values[m]);
    if (static_cast<double>(m % rays.steps) * step <= kInner * radius_mm) inner.push_back(rays.values[m]);
  }
  if (inner.empty()) return {radius_mm, false};
  const double median = quantile(inner, 0.5);
  for (double& x : inner) x = std::fabs(x - median);
  const double range = quantile(finite, 0.99) - quantile(finite, 0.01);
  const double deviation = std::max(kDeviationsOfMedian * quantile(inner, 0.5), kLeastEdgeDeviation * range);
  std::array<double, 2> radii;
  for (std::size_t k = 0; k < radii.size(); ++k)
    radii[k] = rays.edge_distance(median, kDeviations[k] * deviation) * step / radius_mm;
  if (radii[1] > kLargestRatio * radii[0] || radii[1] > 0.95 * kFarthest) return {radius_mm, false};
  const double scale = kSafetyFactor * std::sqrt(radii[0] * radii[1]);
  return {scale < kLeastRatio ? radius_mm : std::min(scale, kMost) * radius_mm, true};
}

}  // namespace simplexseg
