// SPDX-License-Identifier: Apache-2.0
#include "gui/surfaces.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/session.h"

namespace simplexseg {
namespace {

void follow_pose(Surface& surface, const SimplexMesh& mesh) {
  std::copy(mesh.positions.begin(), mesh.positions.end(), surface.points_mm.begin());
  Eigen::Vector3f* centres = surface.points_mm.data() + mesh.positions.size();
  for (int c = 0; c < surface.cells.count(); ++c) {
    Eigen::Vector3f sum(0, 0, 0);
    for (int vertex : surface.cells[c]) sum += mesh.positions[vertex];
    centres[c] = sum / static_cast<float>(surface.cells[c].size());
  }
  // Area-weighted: the cross products are summed as they are.
  surface.normals.assign(surface.points_mm.size(), Eigen::Vector3f::Zero());
  for (const auto& [a, b, c] : surface.triangles) {
    const Eigen::Vector3f origin = surface.points_mm[a];
    const Eigen::Vector3f normal = (surface.points_mm[b] - origin).cross(surface.points_mm[c] - origin);
    surface.normals[a] += normal;
    surface.normals[b] += normal;
    surface.normals[c] += normal;
  }
  for (Eigen::Vector3f& normal : surface.normals) normal.normalize();
}

}  // namespace

void Surfaces::update(const Session& session) {
  if (revision_ == session.revision()) return;
  revision_ = session.revision();
  const std::vector<MeshItem>& items = session.scene().meshes;
  surfaces_.resize(items.size());
  for (std::size_t m = 0; m < items.size(); ++m) {
    const MeshItem& item = items[m];
    Surface& surface = surfaces_[m];
    if (surface.mesh != item.id || surface.neighbours != item.mesh.neighbours) {
      TriangleMesh tessellation = tessellate(item.mesh);
      surface.neighbours = item.mesh.neighbours;
      surface.cells = cells_of(item.mesh);
      surface.triangles = std::move(tessellation.triangles);
      surface.points_mm = std::move(tessellation.positions);
      surface.topology_stamp = next_stamp_++;
    }
    surface.mesh = item.id;
    surface.colour = item.colour;
    surface.visible = item.visible;
    follow_pose(surface, item.mesh);
  }
}

void cut_surface(const Surface& surface, int axis, float position_mm, std::vector<Eigen::Vector3f>& segments_mm) {
  segments_mm.clear();
  const auto& points = surface.points_mm;
  for (const auto& triangle : surface.triangles) {
    float height[3];
    for (int k = 0; k < 3; ++k) height[k] = points[triangle[k]][axis] - position_mm;
    // A point on the plane counts as above it, so a triangle has either no crossing edge or two.
    const int above = (height[0] >= 0) + (height[1] >= 0) + (height[2] >= 0);
    if (above == 0 || above == 3) continue;
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      if ((height[k] >= 0) == (height[next] >= 0)) continue;
      const float t = height[k] / (height[k] - height[next]);
      segments_mm.push_back(points[triangle[k]] + t * (points[triangle[next]] - points[triangle[k]]));
    }
  }
}

// Moeller and Trumbore, Fast, minimum storage ray/triangle intersection, 1997.
std::optional<double> hit_surface(const Surface& surface, const Eigen::Vector3d& origin_mm,
                                  const Eigen::Vector3d& direction) {
  std::optional<double> nearest;
  for (const auto& [a, b, c] : surface.triangles) {
    const Eigen::Vector3d corner = surface.points_mm[a].cast<double>();
    const Eigen::Vector3d e1 = surface.points_mm[b].cast<double>() - corner;
    const Eigen::Vector3d e2 = surface.points_mm[c].cast<double>() - corner;
    const Eigen::Vector3d p = direction.cross(e2);
    const double determinant = e1.dot(p);
    if (std::abs(determinant) < 1e-12) continue;
    const Eigen::Vector3d s = origin_mm - corner;
    const double u = s.dot(p) / determinant;
    const Eigen::Vector3d q = s.cross(e1);
    const double v = direction.dot(q) / determinant;
    if (u < 0 || v < 0 || u + v > 1) continue;
    const double t = e2.dot(q) / determinant;
    if (t > 0 && (!nearest || t < *nearest)) nearest = t;
  }
  return nearest;
}

}  // namespace simplexseg
