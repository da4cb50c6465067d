// SPDX-License-Identifier: Apache-2.0
#include "gui/look/clip_planes.h"

#include <algorithm>
#include <cmath>

#include "core/expect.h"

namespace simplexseg {

Eigen::Vector4f ClipPlane::equation() const {
  Eigen::Vector4f coefficients;
  coefficients << normal.cast<float>(), static_cast<float>(-offset_mm);
  return coefficients;
}

std::vector<ClipPlane> clip_planes(const ClipState& state, const Eigen::Vector3d& crosshair_mm) {
  SIMPLEXSEG_EXPECT(std::abs(state.free_normal.norm() - 1) < 1e-6);
  // LPS: superior, left, anterior.
  const Eigen::Vector3d removed[] = {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}, state.free_normal};
  std::vector<ClipPlane> planes;
  for (std::size_t n = 0; n < kCutPlanes; ++n) {
    if (!state.on[n]) continue;
    const auto plane = static_cast<CutPlane>(n);
    const Eigen::Vector3d normal = state.flipped[n] ? Eigen::Vector3d(-removed[n]) : removed[n];
    planes.push_back({plane, normal, normal.dot(plane == CutPlane::Free ? state.free_point_mm : crosshair_mm)});
  }
  return planes;
}

bool is_clipped(std::span<const ClipPlane> planes, const Eigen::Vector3d& world_mm) {
  constexpr double kToleranceMm = 1e-3;  // marks at the crosshair lie on the planes of the slices
  return std::any_of(planes.begin(), planes.end(),
                     [&](const ClipPlane& plane) { return plane.beyond_mm(world_mm) > kToleranceMm; });
}

RayRange kept_range(std::span<const ClipPlane> planes, const Eigen::Vector3d& origin_mm,
                    const Eigen::Vector3d& direction) {
  RayRange range;
  for (const ClipPlane& plane : planes) {
    const double height = plane.beyond_mm(origin_mm), slope = plane.normal.dot(direction);
    if (slope < 0)
      range.first_mm = std::max(range.first_mm, -height / slope);
    else if (slope > 0)
      range.last_mm = std::min(range.last_mm, -height / slope);
    else if (height > 0)
      return {1, 0};
  }
  return range;
}

std::vector<Eigen::Vector3f> clip_segments(std::span<const ClipPlane> planes, std::vector<Eigen::Vector3f> ends_mm) {
  SIMPLEXSEG_EXPECT(ends_mm.size() % 2 == 0);
  if (planes.empty()) return ends_mm;
  std::vector<Eigen::Vector3f> kept;
  for (std::size_t end = 0; end < ends_mm.size(); end += 2) {
    const Eigen::Vector3d from = ends_mm[end].cast<double>(), along = ends_mm[end + 1].cast<double>() - from;
    const double length_mm = along.norm();
    if (!(length_mm > 0)) continue;
    const RayRange range = kept_range(planes, from, along / length_mm);
    const double last_mm = std::min(range.last_mm, length_mm);
    if (range.first_mm >= last_mm) continue;
    kept.push_back((from + along * (range.first_mm / length_mm)).cast<float>());
    kept.push_back((from + along * (last_mm / length_mm)).cast<float>());
  }
  return kept;
}

}  // namespace simplexseg
