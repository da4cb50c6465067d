// SPDX-License-Identifier: Apache-2.0
// Hit tests against the meshes on the host. Drawing uses SceneBuffers instead.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "gui/look/clip_planes.h"
#include "session/scene.h"

namespace simplexseg {

/// Triangulated surface of one mesh: its vertices and cell centres, and the triangles between them.
struct Surface {
  ItemId mesh = 0;
  TriangleMesh shape;
};

/// Surfaces of the visible meshes, in the pose of the scene.
std::vector<Surface> visible_surfaces(const Scene& scene);

/// Section of the surface with the plane at `position_mm` on world axis `axis`, as segments: start, end, start, end ...
std::vector<Eigen::Vector3f> cut_surface(const TriangleMesh& shape, int axis, float position_mm);

/// Distance (mm) along a ray to the first triangle that it hits within `range`; none without a hit. If a cut begins the
/// range (`first_mm` above 0) inside the closed surface, the ray hits the cut face there. `direction` is a unit vector.
std::optional<double> hit_surface(const TriangleMesh& shape, const Eigen::Vector3d& origin_mm,
                                  const Eigen::Vector3d& direction, const RayRange& range = {});

}  // namespace simplexseg
