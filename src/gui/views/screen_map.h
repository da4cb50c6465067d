// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QPointF>
#include <QSizeF>
#include <optional>

#include "gui/views/orbit_camera.h"

namespace simplexseg {

/// Relation between pixels of the 3D view (logical) and the patient frame.
struct ScreenMap {
  const OrbitCamera& camera;
  QSizeF size;

  double aspect() const { return size.width() / size.height(); }
  OrbitCamera::Ray ray(const QPointF& pixel) const {
    return camera.ray(2 * pixel.x() / size.width() - 1, 1 - 2 * pixel.y() / size.height(), aspect());
  }
  /// None for positions behind the eye.
  std::optional<QPointF> pixel(const Eigen::Vector3d& world_mm) const {
    const Eigen::Vector4d clip = camera.clip_from_eye(aspect()) * (camera.eye_from_world() * world_mm.homogeneous());
    if (clip.w() <= 0) return std::nullopt;
    return QPointF((clip.x() / clip.w() * 0.5 + 0.5) * size.width(), (0.5 - clip.y() / clip.w() * 0.5) * size.height());
  }
  Eigen::Vector3d eye_mm() const { return camera.ray(0, 0, aspect()).origin_mm; }
  /// Unit vectors of the screen in the patient frame: 0 right, 1 up, 2 towards the viewer.
  Eigen::Vector3d axis(int n) const { return camera.eye_from_world().row(n).head<3>(); }
  /// Length of a pixel in the plane through a position that is parallel to the screen, mm.
  double mm_per_pixel(const Eigen::Vector3d& world_mm) const {
    const Eigen::Vector4d at = camera.eye_from_world() * world_mm.homogeneous();
    return 2 * std::max(-at.z(), 1e-9) / (camera.clip_from_eye(aspect())(1, 1) * size.height());
  }
};

}  // namespace simplexseg
