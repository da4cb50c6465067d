// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

namespace simplexseg {

/// Closed contour in a plane, as a user draws it. Places are projected onto the plane.
class PlaneContour {
 public:
  /// `vertices_mm`: at least one; the last is joined to the first. `normal`: unit normal of the plane through the
  /// first.
  PlaneContour(std::span<const Eigen::Vector3d> vertices_mm, const Eigen::Vector3d& normal);

  /// Whether the winding number about a place is not 0: a contour that crosses itself has no holes.
  bool encloses(const Eigen::Vector3d& mm) const { return encloses_in_plane(in_plane(mm)); }
  /// Distance in the plane, mm.
  double distance_mm(const Eigen::Vector3d& mm) const;
  /// Whether distance_mm() is below `limit_mm`; faster where few sides are near.
  bool is_nearer_than(double limit_mm, const Eigen::Vector3d& mm) const;
  /// Coordinates in the plane, mm.
  Eigen::Vector2d in_plane(const Eigen::Vector3d& mm) const { return {u_.dot(mm - origin_), v_.dot(mm - origin_)}; }
  Eigen::Vector3d in_space(const Eigen::Vector2d& p) const { return origin_ + p[0] * u_ + p[1] * v_; }
  /// Places at equal distances along the contour, about `step_mm` apart, from 8 to `most`.
  std::vector<Eigen::Vector2d> resampled(double step_mm, int most) const;

 private:
  bool encloses_in_plane(const Eigen::Vector2d& p) const;
  std::size_t strip_of(double along) const;
  double distance_to_side(const Eigen::Vector2d& p, std::size_t side) const;

  Eigen::Vector3d origin_, u_, v_;
  std::vector<Eigen::Vector2d> vertices_;
  /// Sides, by their first vertex, that cross each of the strips of equal width along the second coordinate.
  std::vector<std::vector<int>> strips_;
  double low_ = 0, high_ = 0;  ///< smallest and largest second coordinate
};

}  // namespace simplexseg
