// SPDX-License-Identifier: Apache-2.0
#include "gui/views/picking.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/expect.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {

std::vector<Surface> visible_surfaces(const Scene& scene) {
  std::vector<Surface> surfaces;
  for (const MeshItem& item : scene.meshes) {
    if (item.visible) surfaces.push_back({item.id, tessellate(item.mesh)});
  }
  return surfaces;
}

std::vector<Eigen::Vector3f> cut_surface(const TriangleMesh& shape, int axis, float position_mm) {
  SIMPLEXSEG_EXPECT(axis >= 0 && axis < 3);
  std::vector<Eigen::Vector3f> segments_mm;
  for (const auto& triangle : shape.triangles) {
    float height[3];
    for (int k = 0; k < 3; ++k) height[k] = shape.positions[triangle[k]][axis] - position_mm;
    // A point on the plane counts as above it: a triangle then has no or two crossing edges (as in DrawOutlines).
    const int above = (height[0] >= 0) + (height[1] >= 0) + (height[2] >= 0);
    if (above == 0 || above == 3) continue;
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      if ((height[k] >= 0) == (height[next] >= 0)) continue;
      const float t = height[k] / (height[k] - height[next]);
      const Eigen::Vector3f &from = shape.positions[triangle[k]], &to = shape.positions[triangle[next]];
      segments_mm.push_back(from + t * (to - from));
    }
  }
  return segments_mm;
}

// Moeller and Trumbore, Fast, minimum storage ray/triangle intersection, 1997.
std::optional<double> hit_surface(const TriangleMesh& shape, const Eigen::Vector3d& origin_mm,
                                  const Eigen::Vector3d& direction, const RayRange& range) {
  SIMPLEXSEG_EXPECT(std::abs(direction.norm() - 1) < 1e-6);
  if (range.first_mm > range.last_mm) return std::nullopt;
  std::optional<double> nearest;
  int beyond_cut = 0;  // triangles beyond the beginning of the range: an odd number inside the surface
  for (const auto& [a, b, c] : shape.triangles) {
    const Eigen::Vector3d corner = shape.positions[a].cast<double>();
    const Eigen::Vector3d e1 = shape.positions[b].cast<double>() - corner;
    const Eigen::Vector3d e2 = shape.positions[c].cast<double>() - corner;
    const Eigen::Vector3d p = direction.cross(e2);
    const double determinant = e1.dot(p);
    if (std::abs(determinant) < 1e-12) continue;
    const Eigen::Vector3d s = origin_mm - corner;
    const double u = s.dot(p) / determinant;
    const Eigen::Vector3d q = s.cross(e1);
    const double v = direction.dot(q) / determinant;
    if (u < 0 || v < 0 || u + v > 1) continue;
    const double t = e2.dot(q) / determinant;
    beyond_cut += t > range.first_mm;
    if (t > range.first_mm && t <= range.last_mm && (!nearest || t < *nearest)) nearest = t;
  }
  if (range.first_mm > 0 && beyond_cut % 2 == 1) return range.first_mm;
  return nearest;
}

}  // namespace simplexseg
