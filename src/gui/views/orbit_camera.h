// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>

namespace simplexseg {

/// Camera that rotates about a target point. Eye frame: x right, y up, viewing direction -z.
class OrbitCamera {
 public:
  /// Centres the view on a sphere, from the patient's front, slightly from the left and above. The shorter side of the
  /// image spans 0.77 of the diameter: the sphere encloses a box that is smaller.
  void fit(const Eigen::Vector3d& centre_mm, double radius_mm);
  void set_target(const Eigen::Vector3d& target_mm) { target_mm_ = target_mm; }
  /// Rotates the scene by angles (rad) for a drag to the right and downwards.
  void rotate(double right, double down);
  /// Moves the target by a drag to the right and downwards, in pixels.
  void pan(double right_px, double down_px, double viewport_height_px);
  /// Multiplies the distance from the target by `factor`, within bounds.
  void zoom(double factor);

  Eigen::Matrix4d eye_from_world() const;
  /// Perspective projection. `aspect`: width over height of the image, above 0.
  Eigen::Matrix4d clip_from_eye(double aspect) const;
  struct Ray {
    Eigen::Vector3d origin_mm, direction;
  };
  /// Ray from the eye through a point of the image: x, y in -1..1, y up.
  Ray ray(double x, double y, double aspect) const;

 private:
  Eigen::Vector3d target_mm_{0, 0, 0};
  Eigen::Quaterniond eye_from_world_{1, 0, 0, 0};
  double distance_mm_ = 500, radius_mm_ = 100;
};

}  // namespace simplexseg
