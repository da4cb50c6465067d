// SPDX-License-Identifier: Apache-2.0
// What a click hits, found among the meshes on the host. What is drawn comes from SceneBuffers.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "session/scene.h"

namespace simplexseg {

/// The surface of one mesh as it is drawn: its vertices and cell centres, and the triangles over them.
struct Surface {
  ItemId mesh = 0;
  TriangleMesh shape;
};

/// The surfaces of the visible meshes, in the pose that the scene has.
std::vector<Surface> visible_surfaces(const Scene& scene);

/// Where the plane (world axis `axis` at `position_mm`) cuts the surface: start, end, start, end ...
std::vector<Eigen::Vector3f> cut_surface(const TriangleMesh& shape, int axis, float position_mm);

/// Distance (mm) along a ray to the first triangle that it meets; `direction` is a unit vector.
std::optional<double> hit_surface(const TriangleMesh& shape, const Eigen::Vector3d& origin_mm,
                                  const Eigen::Vector3d& direction);

}  // namespace simplexseg
