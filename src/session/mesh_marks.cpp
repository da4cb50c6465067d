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

void add_marks(const Scene& scene, const MeshItem& item, const Volume& volume, std::vector<Mark>& marks) {
  marks.push_back({MarkKind::Inside, item.seed.centre_mm, item.seed.radius_mm});
  const double least = kSettings.least_brush * voxel_mm(volume);
  for (const AttractionPoint& point : scene.points) {
    if (point.mesh != item.id || !volume.geometry().contains(point.position_mm)) continue;
    const double radius = std::max(point.radius_mm, least);
    if (point.kind == PointKind::Boundary && !(point.outward.norm() > 0)) continue;
    const MarkKind kind = point.kind == PointKind::Boundary ? MarkKind::Boundary
                          : point.kind == PointKind::Inside ? MarkKind::Inside
                                                            : MarkKind::Outside;
    marks.push_back({kind, point.position_mm, radius, point.outward});
  }
}

}  // namespace

std::vector<Mark> marks_of(const Scene& scene, const MeshItem& item, const Volume& volume) {
  std::vector<Mark> marks;
  add_marks(scene, item, volume, marks);
  return marks;
}

std::vector<Mark> marks_of_others(const Scene& scene, const MeshItem& item, const Volume& volume) {
  std::vector<Mark> others;
  for (const MeshItem& other : scene.meshes) {
    if (other.id == item.id || !takes_field(other, volume)) continue;
    for (const Mark& mark : marks_of(scene, other, volume))
      if (mark.kind == MarkKind::Inside) others.push_back(mark);
  }
  return others;
}

std::vector<Mark> within_reach(std::vector<Mark> others, const MeshField& field, const VolumeGeometry& geometry) {
  if (field.values.empty()) return others;
  const Eigen::Affine3d index = geometry.index_from_world();
  std::erase_if(others, [&](const Mark& mark) {
    const Eigen::Vector3d centre = index * mark.position_mm;
    for (int a = 0; a < 3; ++a) {
      const double reach = mark.radius_mm * index.linear().row(a).norm() + 0.5, at = centre[a] - field.first[a];
      if (at + reach < 0 || at - reach > field.size[a] - 1) return true;
    }
    return false;
  });
  return others;
}

bool has_stale_field(const Scene& scene, const MeshItem& item, const Volume& volume) {
  if (!takes_field(item, volume)) return false;
  if (!item.field) return true;
  const std::vector<Mark> others = within_reach(marks_of_others(scene, item, volume), *item.field, volume.geometry());
  return marks_of(scene, item, volume) != item.field->marks || others != item.field->others;
}

double mark_radius_mm(const MeshItem& item, PointKind kind, const Eigen::Vector3d& position_mm, const Volume& volume) {
  const double least = kSettings.least_brush * voxel_mm(volume);
  if (!item.has_field() || kind == PointKind::Boundary) return least;
  const bool inside = kind == PointKind::Inside;
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
