// SPDX-License-Identifier: Apache-2.0
#include "image/plane_contour.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/expect.h"

namespace simplexseg {

PlaneContour::PlaneContour(std::span<const Eigen::Vector3d> vertices_mm, const Eigen::Vector3d& normal) {
  SIMPLEXSEG_EXPECT(!vertices_mm.empty());
  origin_ = vertices_mm[0];
  u_ = normal.unitOrthogonal(), v_ = normal.cross(u_);
  for (const Eigen::Vector3d& vertex : vertices_mm) vertices_.push_back(in_plane(vertex));
  const auto [low, high] = std::ranges::minmax_element(
      vertices_, [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a[1] < b[1]; });
  low_ = (*low)[1], high_ = (*high)[1];
  strips_.resize(std::clamp<std::size_t>(vertices_.size(), 1, 256));
  for (std::size_t n = 0; n < vertices_.size(); ++n) {
    const double a = vertices_[n][1], b = vertices_[(n + 1) % vertices_.size()][1];
    for (std::size_t s = strip_of(std::min(a, b)); s <= strip_of(std::max(a, b)); ++s)
      strips_[s].push_back(static_cast<int>(n));
  }
}

std::size_t PlaneContour::strip_of(double along) const {
  const double share = high_ > low_ ? (along - low_) / (high_ - low_) : 0;
  const auto last = static_cast<double>(strips_.size() - 1);
  return static_cast<std::size_t>(std::clamp(share * static_cast<double>(strips_.size()), 0.0, last));
}

// Method: Sunday 2001, Inclusion of a Point in a Polygon.
bool PlaneContour::encloses_in_plane(const Eigen::Vector2d& p) const {
  if (p[1] < low_ || p[1] > high_) return false;
  int winding = 0;
  for (const int side : strips_[strip_of(p[1])]) {
    const auto n = static_cast<std::size_t>(side);
    const Eigen::Vector2d &a = vertices_[n], &b = vertices_[(n + 1) % vertices_.size()];
    if ((a[1] <= p[1]) == (b[1] <= p[1])) continue;
    const Eigen::Vector2d along = b - a, to = p - a;
    const double left = along[0] * to[1] - along[1] * to[0];
    if (b[1] > p[1] && left > 0) ++winding;
    if (b[1] <= p[1] && left < 0) --winding;
  }
  return winding != 0;
}

double PlaneContour::distance_mm(const Eigen::Vector3d& mm) const {
  const Eigen::Vector2d p = in_plane(mm);
  double least = std::numeric_limits<double>::max();
  for (std::size_t n = 0; n < vertices_.size(); ++n) least = std::min(least, distance_to_side(p, n));
  return least;
}

double PlaneContour::distance_to_side(const Eigen::Vector2d& p, std::size_t side) const {
  const Eigen::Vector2d &a = vertices_[side], along = vertices_[(side + 1) % vertices_.size()] - a, to = p - a;
  const double squared = along.squaredNorm();
  const double t = squared > 0 ? std::clamp(to.dot(along) / squared, 0.0, 1.0) : 0;
  return (to - t * along).norm();
}

bool PlaneContour::is_nearer_than(double limit_mm, const Eigen::Vector3d& mm) const {
  const Eigen::Vector2d p = in_plane(mm);
  const std::size_t last = strip_of(p[1] + limit_mm);
  for (std::size_t s = strip_of(p[1] - limit_mm); s <= last; ++s)
    for (const int side : strips_[s])
      if (distance_to_side(p, static_cast<std::size_t>(side)) < limit_mm) return true;
  return false;
}

std::vector<Eigen::Vector2d> PlaneContour::resampled(double step_mm, int most) const {
  double length_mm = 0;
  const auto end_of = [&](std::size_t n) { return vertices_[(n + 1) % vertices_.size()]; };
  for (std::size_t n = 0; n < vertices_.size(); ++n) length_mm += (end_of(n) - vertices_[n]).norm();
  const int count = static_cast<int>(std::clamp(std::round(length_mm / step_mm), 8.0, static_cast<double>(most)));
  std::vector<Eigen::Vector2d> places;
  double passed_mm = 0;
  for (std::size_t n = 0; n < vertices_.size(); ++n) {
    const Eigen::Vector2d along = end_of(n) - vertices_[n];
    for (; static_cast<int>(places.size()) < count;) {
      const double at_mm = length_mm * static_cast<double>(places.size()) / count - passed_mm;
      if (at_mm > along.norm()) break;
      places.push_back(vertices_[n] + (along.norm() > 0 ? at_mm / along.norm() : 0) * along);
    }
    passed_mm += along.norm();
  }
  return places;
}

}  // namespace simplexseg
