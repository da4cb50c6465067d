// SPDX-License-Identifier: Apache-2.0
#include "session/mesh_sleep.h"

#include "core/digest.h"
#include "image/volume.h"
#include "session/mesh_lifecycle.h"

namespace simplexseg {

std::uint64_t input_digest(const MeshItem& item, const Scene& scene, const Volume& volume) {
  Digest digest;
  digest.add(active_parameters(item, volume));
  digest.add(scene.simulation);
  for (const UserPoint& point : scene.points)
    if (point.mesh == item.id && point.kind == MarkKind::Boundary) digest.add(point.position_mm.data(), 3);
  if (!volume.empty()) {
    const VolumeGeometry& geometry = volume.geometry();
    digest.add(geometry.size), digest.add(geometry.world_from_index().matrix().data(), 16);
  }
  const std::string filters = key_of(scene.volume_preprocessing.filters);
  digest.add(filters.data(), filters.size());
  return digest.value();
}

void wake_changed_meshes(Scene& scene, const Volume& volume) {
  for (MeshItem& item : scene.meshes)
    if (const std::uint64_t inputs = input_digest(item, scene, volume); inputs != item.sleep.inputs)
      item.sleep = {.inputs = inputs};
}

std::vector<char> sleeping_meshes(const Scene& scene) {
  std::vector<char> asleep;
  for (const MeshItem& item : scene.meshes) asleep.push_back(item.sleep.asleep);
  return asleep;
}

}  // namespace simplexseg
