// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>

namespace simplexseg {

/// Similarity p -> scale R p + shift.
struct Similarity {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d shift_mm{0, 0, 0};

  Eigen::Vector3d operator()(const Eigen::Vector3d& mm) const { return scale * (rotation * mm) + shift_mm; }
  /// Images of points, one per column.
  Eigen::Matrix3Xd operator()(const Eigen::Matrix3Xd& mm) const {
    return ((scale * rotation) * mm).colwise() + shift_mm;
  }
};

/// Similarity that maps points to points, one per column, with the least sum of squared distances. The points must not
/// all coincide. Source: Umeyama 1991, Least-squares estimation of transformation parameters between two point
/// patterns.
Similarity fit_similarity(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to);

/// Rotation vector (axis times angle, radians) of a rotation, and the inverse.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation);
Eigen::Matrix3d rotation_of(const Eigen::Vector3d& vector);

}  // namespace simplexseg
