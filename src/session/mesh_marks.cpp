// SPDX-License-Identifier: Apache-2.0
#include "session/mesh_marks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "evidence/evidence_settings.h"
#include "forces/force_list.h"
#include "image/volume.h"
#include "mesh/mesh_geometry.h"
#include "session/mesh_life.h"

namespace simplexseg {
namespace {

constexpr EvidenceSettings kSettings;

}  // namespace

std::vector<Mark> marks_of(const Scene& scene, const MeshItem& item, const Volume& volume) {
  std::vector<Mark> marks{{MarkKind::Inside, item.seed.centre_mm, item.seed.radius_mm}};
  const double least = kSettings.least_brush * voxel_mm(volume);
  for (const AttractionPoint& point : scene.points) {
    if (point.mesh != item.id || !volume.geometry().contains(point.position_mm)) continue;
    if (point.kind == MarkKind::Boundary && !(point.outward.norm() > 0)) continue;
    marks.push_back({point.kind, point.position_mm, std::max(point.radius_mm, least), point.outward});
  }
  return marks;
}

bool has_stale_field(const Scene& scene, const MeshItem& item, const Volume& volume) {
  if (!takes_field(item, volume)) return false;
  if (!item.field) return true;
  return marks_of(scene, item, volume) != item.field->marks;
}

double mark_radius_mm(const MeshItem& item, MarkKind kind, const Eigen::Vector3d& position_mm, const Volume& volume) {
  const double least = kSettings.least_brush * voxel_mm(volume);
  if (!item.has_field() || kind == MarkKind::Boundary) return least;
  const bool inside = kind == MarkKind::Inside;
  const MeshField& field = *item.field;
  const Eigen::Affine3d world = volume.geometry().world_from_index();
  double square = std::numeric_limits<double>::infinity();
  std::size_t v = 0;
  for (int k = 0; k < field.size[2]; ++k)
    for (int j = 0; j < field.size[1]; ++j)
      for (int i = 0; i < field.size[0]; ++i, ++v) {
        if ((field.values[v] > 32767) != inside) continue;  // of the other side than the mark says
        const Eigen::Vector3d at(i + field.first[0], j + field.first[1], k + field.first[2]);
        square = std::min(square, (world * at - position_mm).squaredNorm());
      }
  double radius = kSettings.brush * std::sqrt(square);
  for (const Mark& mark : field.marks)
    if ((mark.kind == MarkKind::Inside) != inside)
      radius = std::min(radius, 0.5 * std::max(0.0, (mark.position_mm - position_mm).norm() - mark.radius_mm));
  return std::isfinite(radius) ? std::max(least, radius) : least;
}

Eigen::Vector3d outward_at(const MeshItem& item, const Eigen::Vector3d& position_mm, const Volume& volume) {
  const SimplexMesh& mesh = item.mesh;
  if (mesh.positions.empty()) return Eigen::Vector3d::Zero();
  int nearest = 0;
  double square = std::numeric_limits<double>::infinity();
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const double d = (mesh.positions[v].cast<double>() - position_mm).squaredNorm();
    if (d < square) square = d, nearest = v;
  }
  Eigen::Vector3d normal = vertex_geometry(mesh, nearest).normal;
  const Eigen::Vector3d way = position_mm - mesh.positions[nearest].cast<double>();
  if (way.norm() < voxel_mm(volume)) return normal;
  return way.dot(normal) > 0 ? Eigen::Vector3d(way.normalized()) : Eigen::Vector3d(-way.normalized());
}

}  // namespace simplexseg
