// SPDX-License-Identifier: Apache-2.0
// Meshes on the host, for what a click hits. They are drawn from SceneBuffers.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "session/scene.h"

namespace simplexseg {

/// What is drawn of one mesh: its vertices and cell centres, and the triangles over them.
struct Surface {
  ItemId mesh = 0;
  TriangleMesh shape;
};

/// Of the visible meshes, in the pose that the scene has.
std::vector<Surface> visible_surfaces(const Scene& scene);

/// Where the plane (world axis `axis` at `position_mm`) cuts the surface: start, end, start, end ...
std::vector<Eigen::Vector3f> cut_surface(const TriangleMesh& shape, int axis, float position_mm);

/// Distance (mm) along a ray to the first triangle that it meets.
std::optional<double> hit_surface(const TriangleMesh& shape, const Eigen::Vector3d& origin_mm,
                                  const Eigen::Vector3d& direction);

}  // namespace simplexseg
