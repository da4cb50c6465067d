// SPDX-License-Identifier: Apache-2.0
// Planes that cut meshes, slices and volume in the 3D view.
#pragma once
#include <Eigen/Core>
#include <array>
#include <limits>
#include <span>
#include <vector>

namespace simplexseg {

/// Planes of the 3D view: the three slices, in the order of Orientation, and one that the user places.
enum class CutPlane : int { Axial, Sagittal, Coronal, Free };
inline constexpr int kCutPlanes = 4;

/// Planes in use, the sides that they remove, and the position of the free plane.
struct ClipState {
  std::array<bool, kCutPlanes> on{};
  std::array<bool, kCutPlanes> flipped{};  ///< removes the other side
  Eigen::Vector3d free_point_mm{0, 0, 0};
  Eigen::Vector3d free_normal{0, 0, 1};  ///< unit vector to the side that is removed unless flipped
  bool free_placed = false;              ///< the free plane has a position in the open volume
  bool image_on_caps = true;             ///< cut faces show the image
  bool any() const { return on[0] || on[1] || on[2] || on[3]; }
};

/// Plane that removes all points x with normal . x > offset_mm.
struct ClipPlane {
  CutPlane plane = CutPlane::Axial;
  Eigen::Vector3d normal{0, 0, 1};  ///< unit vector
  double offset_mm = 0;
  /// Signed distance to the plane, mm; above 0 on the side that is removed.
  double beyond_mm(const Eigen::Vector3d& world_mm) const { return normal.dot(world_mm) - offset_mm; }
  /// Coefficients (normal, -offset) for shaders.
  Eigen::Vector4f equation() const;
};

/// Planes in use, with the slices at the crosshair. Unless flipped, the slice planes remove what is superior, left and
/// anterior of them, the sides that face the first view of a volume.
std::vector<ClipPlane> clip_planes(const ClipState& state, const Eigen::Vector3d& crosshair_mm);
/// Returns true if a plane removes the point; points within 0.001 mm of a plane are kept.
bool is_clipped(std::span<const ClipPlane> planes, const Eigen::Vector3d& world_mm);

/// Part of a ray, in mm from its origin; empty if `first_mm` > `last_mm`.
struct RayRange {
  double first_mm = 0, last_mm = std::numeric_limits<double>::infinity();
};
/// Part of a ray that no plane removes. `direction`: unit vector.
RayRange kept_range(std::span<const ClipPlane> planes, const Eigen::Vector3d& origin_mm,
                    const Eigen::Vector3d& direction);
/// Segments (start, end, start, end ...) without the parts that a plane removes.
std::vector<Eigen::Vector3f> clip_segments(std::span<const ClipPlane> planes, std::vector<Eigen::Vector3f> ends_mm);

}  // namespace simplexseg
