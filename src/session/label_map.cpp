// SPDX-License-Identifier: Apache-2.0
#include "session/label_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
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
/// stroke in the scene counts. Voxels that it removes from an object remain with the others.
template <class T>
void set_painted_voxels(const Scene& scene, const VolumeGeometry& geometry, std::span<T> voxels) {
  const VoxelBox all{{0, 0, 0}, geometry.size};
  // From the last stroke to the first: a voxel is decided by the first that is met.
  std::vector<bool> decided;
  std::map<ItemId, std::vector<bool>> erased;  // of each mesh
  for (std::size_t p = scene.points.size(); p-- > 0;) {
    const UserPoint& point = scene.points[p];
    const MeshItem* const item = point.is_paint() ? scene.find_mesh(point.mesh) : nullptr;
    if (!item || item->mesh.positions.empty()) continue;
    std::vector<bool>& removed = erased[item->id];
    decided.resize(voxels.size()), removed.resize(voxels.size());
    for_each_voxel(paint_stroke_of(point), geometry, [&](int i, int j, int k, bool inside) {
      const std::size_t v = all.offset(i, j, k);
      if (!inside)
        removed[v] = true;
      else if (!removed[v] && !decided[v])
        decided[v] = true, voxels[v] = static_cast<T>(item->label);
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
