// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>

namespace simplexseg {

/// A camera that turns about a point. Eye frame: x right, y up, looking along -z.
class OrbitCamera {
 public:
  /// Looks at a sphere from the patient's front, a little from the left and above.
  void fit(const Eigen::Vector3d& centre_mm, double radius_mm);
  void look_at(const Eigen::Vector3d& centre_mm) { target_mm_ = centre_mm; }
  /// Turns by a drag of so many radians to the right and downwards.
  void rotate(double right, double down);
  /// Moves the target by a drag in pixels.
  void pan(double right_px, double down_px, double viewport_height_px);
  void zoom(double factor);

  Eigen::Matrix4d eye_from_world() const;
  /// `aspect`: the picture's width over its height, above 0.
  Eigen::Matrix4d clip_from_eye(double aspect) const;
  struct Ray {
    Eigen::Vector3d origin_mm, direction;
  };
  /// Through a place of the picture: x, y in -1..1, y up.
  Ray ray(double x, double y, double aspect) const;

 private:
  Eigen::Vector3d target_mm_{0, 0, 0};
  Eigen::Quaterniond eye_from_world_{1, 0, 0, 0};
  double distance_mm_ = 500, radius_mm_ = 100;
};

}  // namespace simplexseg
