// SPDX-License-Identifier: Apache-2.0
#include "gui/views/orbit_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/expect.h"

namespace simplexseg {
namespace {
constexpr double kHalfAngle = 15 * std::numbers::pi / 180;  // from the centre to the nearest edge of the image, rad
}

void OrbitCamera::fit(const Eigen::Vector3d& centre_mm, double radius_mm) {
  target_mm_ = centre_mm;
  radius_mm_ = std::max(radius_mm, 1e-3);
  distance_mm_ = radius_mm_ / std::sin(kHalfAngle) * 0.74;
  // Eye axes from the front: x = left of the patient, y = superior, z = anterior (LPS: +x, +z, -y).
  Eigen::Matrix3d from_front;
  from_front << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  eye_from_world_ = Eigen::Quaterniond(from_front);
  rotate(-0.6, 0.3);
}

void OrbitCamera::rotate(double right, double down) {
  eye_from_world_ = (Eigen::AngleAxisd(down, Eigen::Vector3d::UnitX()) *
                     Eigen::AngleAxisd(right, Eigen::Vector3d::UnitY()) * eye_from_world_)
                        .normalized();
}

void OrbitCamera::pan(double right_px, double down_px, double viewport_height_px) {
  const double mm_per_px = 2 * distance_mm_ * std::tan(kHalfAngle) / std::max(viewport_height_px, 1.0);
  target_mm_ += eye_from_world_.conjugate() * Eigen::Vector3d(-right_px * mm_per_px, down_px * mm_per_px, 0);
}

void OrbitCamera::zoom(double factor) {
  distance_mm_ = std::clamp(distance_mm_ * factor, 0.05 * radius_mm_, 40 * radius_mm_);
}

Eigen::Matrix4d OrbitCamera::eye_from_world() const {
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  transform.linear() = eye_from_world_.toRotationMatrix();
  transform.translation() = Eigen::Vector3d(0, 0, -distance_mm_) - transform.linear() * target_mm_;
  return transform.matrix();
}

Eigen::Matrix4d OrbitCamera::clip_from_eye(double aspect) const {
  SIMPLEXSEG_EXPECT(aspect > 0);
  // The full angle spans the shorter side of the image.
  const double scale = 1 / std::tan(kHalfAngle) * std::min(aspect, 1.0);
  const double near = std::max(distance_mm_ - 4 * radius_mm_, 0.01 * distance_mm_), far = distance_mm_ + 4 * radius_mm_;
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip(0, 0) = scale / aspect;
  clip(1, 1) = scale;
  clip(2, 2) = -(far + near) / (far - near);
  clip(2, 3) = -2 * far * near / (far - near);
  clip(3, 2) = -1;
  return clip;
}

OrbitCamera::Ray OrbitCamera::ray(double x, double y, double aspect) const {
  SIMPLEXSEG_EXPECT(aspect > 0);
  const double scale = 1 / std::tan(kHalfAngle) * std::min(aspect, 1.0);
  const Eigen::Quaterniond world_from_eye = eye_from_world_.conjugate();
  const Eigen::Vector3d eye = target_mm_ + world_from_eye * Eigen::Vector3d(0, 0, distance_mm_);
  return {eye, (world_from_eye * Eigen::Vector3d(x * aspect / scale, y / scale, -1)).normalized()};
}

}  // namespace simplexseg
