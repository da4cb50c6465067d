// SPDX-License-Identifier: Apache-2.0
#include "session/mesh_marks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "field/brush_radius.h"
#include "field/stroke.h"
#include "image/volume.h"
#include "mesh/mesh_geometry.h"
#include "session/mesh_lifecycle.h"

namespace simplexseg {

std::vector<Mark> marks_of(const Scene& scene, const MeshItem& item, const Volume& volume) {
  std::vector<Mark> marks{{MarkKind::Inside, item.seed.centre_mm, item.seed.radius_mm}};
  // Smallest radius of a boundary mark, and radius of the other marks whose points have none.
  const double min_radius_mm = far_brush_radius_mm(volume.geometry());
  for (const UserPoint& point : scene.points) {
    if (point.mesh != item.id || point.is_paint()) continue;
    if (point.is_lasso() && point.strokes) {
      std::vector<Mark> lasso = marks_of_strokes(*point.strokes, point.continues ? MarkLink::Update : MarkLink::None);
      for (Mark& mark : lasso) mark.local = point.local;
      marks.insert(marks.end(), lasso.begin(), lasso.end());
    }
    if (point.is_lasso() || !volume.geometry().contains(point.position_mm)) continue;
    if (point.kind == MarkKind::Boundary && !(point.outward.norm() > 0)) continue;
    if (point.kind == MarkKind::Boundary) {
      marks.push_back({point.kind, point.position_mm, std::max(point.radius_mm, min_radius_mm), point.outward,
                       MarkLink::None, point.local});
      continue;
    }
    const double radius_mm = point.radius_mm > 0 ? point.radius_mm : min_radius_mm;
    std::vector<Mark> stroke = marks_of_stroke(point.kind, point.vertices_mm(), radius_mm);
    std::erase_if(stroke, [&](const Mark& mark) { return !volume.geometry().contains(mark.position_mm); });
    for (Mark& mark : stroke) mark.local = point.local;
    if (!stroke.empty()) stroke[0].link = point.continues ? MarkLink::Update : MarkLink::None;
    marks.insert(marks.end(), stroke.begin(), stroke.end());
  }
  return marks;
}

std::vector<Mark> marks_of_others(const Scene& scene, const MeshItem& item, const Volume& volume) {
  std::vector<Mark> others;
  for (const MeshItem& other : scene.meshes) {
    if (other.id == item.id || !uses_field(other, volume)) continue;
    for (const Mark& mark : marks_of(scene, other, volume))
      if (mark.kind == MarkKind::Inside) others.push_back(mark);
  }
  return others;
}

std::vector<Mark> within_reach(std::vector<Mark> others, const MeshField& field, const VolumeGeometry& geometry) {
  if (field.values.empty()) return others;
  const VoxelBox& box = field.solved ? field.solved->box : field.box;  // paint may have enlarged the box
  const Eigen::Affine3d index = cell_geometry(geometry, field.cell).index_from_world();
  std::erase_if(others, [&](const Mark& mark) {
    const Eigen::Vector3d centre = index * mark.position_mm;
    for (int a = 0; a < 3; ++a) {
      const double reach = mark.radius_mm * index.linear().row(a).norm() + 0.5, at = centre[a] - box.first[a];
      if (at + reach < 0 || at - reach > box.size[a] - 1) return true;
    }
    return false;
  });
  return others;
}

bool has_stale_field(const Scene& scene, const MeshItem& item, const Volume& volume) {
  if (!uses_field(item, volume)) return false;
  if (!item.field) return true;
  if (!item.is_given() &&
      (item.intensity_range != item.field->intensity_range || item.prior_identity() != item.field->model ||
       digest_of(scene, item.images) != item.field->images ||
       key_of(scene.volume_preprocessing.filters) != item.field->filters))
    return true;
  const std::vector<Mark> others = within_reach(marks_of_others(scene, item, volume), *item.field, volume.geometry());
  return marks_of(scene, item, volume) != item.field->marks || others != item.field->others;
}

CancelledUpdate cancelled_update(const Scene& scene, const MeshItem& item, const Volume& volume) {
  CancelledUpdate update{marks_of(scene, item, volume), {}};
  if (item.has_field())
    update.others = within_reach(marks_of_others(scene, item, volume), *item.field, volume.geometry());
  return update;
}

bool is_update_cancelled(const Scene& scene, const MeshItem& item, const Volume& volume) {
  return item.cancelled && has_stale_field(scene, item, volume) &&
         cancelled_update(scene, item, volume) == *item.cancelled;
}

bool is_update_due(const Scene& scene, const MeshItem& item, const Volume& volume) {
  return has_stale_field(scene, item, volume) && !is_update_cancelled(scene, item, volume);
}

double mark_radius_mm(const MeshItem& item, MarkKind kind, const Eigen::Vector3d& position_mm, const Volume& volume,
                      const EvidenceSettings& fields) {
  const VolumeGeometry& geometry = volume.geometry();
  if (!item.has_field()) return far_brush_radius_mm(geometry);
  const MeshField& field = *item.field;
  const VolumeGeometry cells = cell_geometry(geometry, field.cell);
  return brush_radius_mm(cells, field.box, field.object_cells(), kind, position_mm, fields);
}

double stroke_radius_mm(const MeshItem& item, const UserPoint& stroke, const Volume& volume,
                        const EvidenceSettings& fields) {
  if (!item.has_field()) return far_brush_radius_mm(volume.geometry());
  const VolumeGeometry cells = cell_geometry(volume.geometry(), item.field->cell);
  const std::vector<std::uint8_t> object = item.field->object_cells();
  double radius_mm = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& at : stroke.vertices_mm())
    radius_mm = std::min(radius_mm, brush_radius_mm(cells, item.field->box, object, stroke.kind, at, fields));
  return radius_mm;
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
  const Eigen::Vector3d to_point = position_mm - mesh.positions[nearest].cast<double>();
  if (to_point.norm() < voxel_mm(volume)) return normal;
  return to_point.dot(normal) > 0 ? Eigen::Vector3d(to_point.normalized()) : Eigen::Vector3d(-to_point.normalized());
}

}  // namespace simplexseg
