// SPDX-License-Identifier: Apache-2.0
#include "session/label_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "core/error.h"
#include "session/paint.h"

namespace simplexseg {

namespace {

/// Encoded value (FieldBox in src/forces/step_view.h) of the cell that contains a place, in the field of a mesh without
/// its paint. It increases with the foreground probability; 0 outside the field's box; none without a field. `place`:
/// index in the grid of the volume.
std::optional<float> field_at(const MeshItem& item, const Eigen::Vector3d& place) {
  if (!item.has_field()) return std::nullopt;
  const MeshField& field = item.field->solved ? *item.field->solved : *item.field;
  std::array<int, 3> at;
  for (int a = 0; a < 3; ++a) {
    at[a] = static_cast<int>(std::floor((place[a] + 0.5) / field.cell[a])) - field.box.first[a];
    if (at[a] < 0 || at[a] >= field.box.size[a]) return 0.0f;
  }
  return field.values[field.box.offset(at[0], at[1], at[2])];
}

/// Voxels that paint puts into an object belong to it, whatever the surfaces and fields of others contain; the last
/// stroke in the scene counts. Voxels that it removes from an object remain with the others. A frozen part changes no
/// label.
template <class T>
void set_painted_voxels(const Scene& scene, const VolumeGeometry& geometry, std::span<T> voxels) {
  const VoxelBox all{{0, 0, 0}, geometry.size};
  for (std::size_t p = 0; p < scene.points.size(); ++p) {
    const UserPoint& point = scene.points[p];
    if (!point.is_paint() || point.edit == VoxelEdit::Freeze) continue;
    const MeshItem* const item = scene.find_mesh(point.mesh);
    if (!item || item->mesh.positions.empty()) continue;
    StrokeVoxels stroke = voxels_of(paint_stroke_of(point), geometry);
    // Later strokes remove voxels of the same object again.
    for (std::size_t later = p + 1; later < scene.points.size(); ++later) {
      const UserPoint& eraser = scene.points[later];
      if (!eraser.is_paint() || eraser.mesh != point.mesh) continue;
      voxels_of(paint_stroke_of(eraser), geometry, stroke.box).for_each([&](int i, int j, int k, bool inside) {
        if (inside) return;
        stroke.voxels[stroke.box.offset(i - stroke.box.first[0], j - stroke.box.first[1], k - stroke.box.first[2])] =
            VoxelPaint::None;
      });
    }
    stroke.for_each([&](int i, int j, int k, bool inside) {
      if (inside) voxels[all.offset(i, j, k)] = static_cast<T>(item->label);
    });
  }
}

}  // namespace

void require_label_numbers(const Scene& scene) {
  for (const MeshItem& item : scene.meshes) {
    if (item.label < 1 || item.label > 65535) {
      throw Error("segmentation '" + item.name + "'", "its label is " + std::to_string(item.label),
                  "give it a label from 1 to 65535");
    }
  }
}

LabelMap make_label_map(const Scene& scene, const VolumeGeometry& geometry) {
  return make_label_map(scene, geometry, geometry);
}

LabelMap make_label_map(const Scene& scene, const VolumeGeometry& geometry, const VolumeGeometry& volume) {
  require_label_numbers(scene);
  int largest = 1;
  for (const MeshItem& item : scene.meshes) largest = std::max(largest, item.label);
  LabelMap map{Volume(geometry, largest < 256 ? VoxelType::UInt8 : VoxelType::UInt16)};
  const auto paint = [&]<class T>(std::type_identity<T>) {
    const std::span<T> voxels = map.labels.voxels<T>();
    std::vector<const MeshItem*> owner(voxels.size());
    const Eigen::Affine3d in_volume = volume.index_from_world() * geometry.world_from_index();
    const auto place_of = [&](std::size_t v) -> Eigen::Vector3d {
      const auto ni = static_cast<std::size_t>(geometry.size[0]), nj = static_cast<std::size_t>(geometry.size[1]);
      return in_volume * Eigen::Vector3d(static_cast<double>(v % ni), static_cast<double>(v / ni % nj),
                                         static_cast<double>(v / ni / nj));
    };
    for (const MeshItem& item : scene.meshes) {
      if (item.mesh.positions.empty()) continue;
      const Mask mask = object_mask(item.mesh, paint_of(scene, item.id), geometry);
      for (std::size_t v = 0; v < voxels.size(); ++v) {
        if (!mask.voxels[v]) continue;
        map.shared_voxels += owner[v] != nullptr;
        if (owner[v]) {
          const Eigen::Vector3d place = place_of(v);
          const std::optional<float> own = field_at(item, place), before = field_at(*owner[v], place);
          if (!own || !before || *own <= *before) continue;
        }
        owner[v] = &item, voxels[v] = static_cast<T>(item.label);
      }
    }
    set_painted_voxels(scene, geometry, voxels);
  };
  visit_voxel_type(map.labels.type(), paint);
  return map;
}

}  // namespace simplexseg
