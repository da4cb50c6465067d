// SPDX-License-Identifier: Apache-2.0
#include "session/label_map.h"

#include <algorithm>

#include "core/error.h"
#include "image/rasterise.h"

namespace simplexseg {

LabelMap make_label_map(const Scene& scene, const VolumeGeometry& geometry) {
  int largest = 1;
  for (const MeshItem& item : scene.meshes) {
    if (item.label < 1 || item.label > 65535) {
      throw Error("mesh '" + item.name + "'", "its label is " + std::to_string(item.label),
                  "give it a label from 1 to 65535");
    }
    largest = std::max(largest, item.label);
  }
  LabelMap map{Volume(geometry, largest < 256 ? VoxelType::UInt8 : VoxelType::UInt16)};
  const auto paint = [&]<class T>(std::type_identity<T>) {
    const std::span<T> voxels = map.labels.voxels<T>();
    for (const MeshItem& item : scene.meshes) {
      if (item.mesh.positions.empty()) continue;
      const Mask mask = rasterise(item.mesh, geometry);
      for (std::size_t v = 0; v < voxels.size(); ++v) {
        if (!mask.voxels[v]) continue;
        if (voxels[v] == 0) {
          voxels[v] = static_cast<T>(item.label);
        } else {
          ++map.shared_voxels;
        }
      }
    }
  };
  visit_voxel_type(map.labels.type(), paint);
  return map;
}

}  // namespace simplexseg
