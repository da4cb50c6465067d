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
}

// Method: Sunday 2001, Inclusion of a Point in a Polygon.
bool PlaneContour::encloses_in_plane(const Eigen::Vector2d& p) const {
  int winding = 0;
  for (std::size_t n = 0; n < vertices_.size(); ++n) {
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
  for (std::size_t n = 0; n < vertices_.size(); ++n) {
    const Eigen::Vector2d &a = vertices_[n], along = vertices_[(n + 1) % vertices_.size()] - a, to = p - a;
    const double squared = along.squaredNorm();
    const double t = squared > 0 ? std::clamp(to.dot(along) / squared, 0.0, 1.0) : 0;
    least = std::min(least, (to - t * along).norm());
  }
  return least;
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
