// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/plane_positions.h"

#include <algorithm>
#include <numeric>

namespace simplexseg {
namespace {

/// Largest part of the plane distance between positions of one plane.
constexpr double kTolerance = 0.01;

/// Returns true when gaps of at most `tolerance` join no positions that are further apart.
bool are_planes(const std::vector<double>& sorted, double tolerance) {
  double first = sorted.front();
  for (std::size_t p = 1; p < sorted.size(); ++p) {
    if (sorted[p] - sorted[p - 1] > tolerance) first = sorted[p];
    if (sorted[p] - first > tolerance) return false;
  }
  return true;
}

}  // namespace

double lower_median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double PlanePositions::distance() const {
  std::vector<double> gaps;
  for (std::size_t p = 1; p < planes.size(); ++p) gaps.push_back(planes[p] - planes[p - 1]);
  return lower_median(std::move(gaps));
}

PlanePositions planes_of(const std::vector<double>& positions, double tolerance) {
  std::vector<std::size_t> order(positions.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return positions[a] < positions[b]; });
  PlanePositions result;
  result.plane_of.resize(positions.size());
  for (const std::size_t p : order) {
    if (result.planes.empty() || positions[p] - result.planes.back() > tolerance) result.planes.push_back(positions[p]);
    result.plane_of[p] = result.planes.size() - 1;
  }
  return result;
}

double plane_tolerance(std::vector<double> positions, double noise, double limit) {
  std::sort(positions.begin(), positions.end());
  std::vector<double> gaps;
  for (std::size_t p = 1; p < positions.size(); ++p)
    if (const double gap = positions[p] - positions[p - 1]; gap > noise) gaps.push_back(gap);
  while (!gaps.empty()) {
    const double largest = *std::max_element(gaps.begin(), gaps.end());
    std::vector<double> of_planes = gaps;
    std::erase_if(of_planes, [&](double gap) { return gap <= kTolerance * largest; });
    const double tolerance = std::clamp(kTolerance * lower_median(std::move(of_planes)), noise, limit);
    if (are_planes(positions, tolerance)) return tolerance;
    std::erase_if(gaps, [&](double gap) { return gap > kTolerance * largest; });
  }
  return noise;
}

}  // namespace simplexseg
