// SPDX-License-Identifier: Apache-2.0
#include "session/engine_scene.h"

#include "session/mesh_lifecycle.h"

namespace simplexseg {

EngineScene engine_scene(const Scene& scene, const Volume& volume) {
  EngineScene loaded;
  for (const MeshItem& item : scene.meshes) {
    EngineMesh m;
    m.positions = item.mesh.positions, m.previous = item.previous, m.neighbours = item.mesh.neighbours;
    m.shape = item.shape, m.profiles = item.profiles, m.region = &item.region;
    m.parameters = active_parameters(item, volume);
    m.finest = is_finest(item, scene.simulation, voxel_mm(volume));
    m.solver = item.solver;
    m.edge_mm = item.edge_mm;
    m.asleep = item.sleep.asleep;
    m.field = engine_field(item);
    loaded.meshes.push_back(m);
  }
  loaded.points = engine_points(scene);
  return loaded;
}

EngineField engine_field(const MeshItem& item) {
  if (!item.has_field()) return {};
  return {item.field->cell, item.field->box, item.field->values, item.field};
}

std::vector<EnginePoint> engine_points(const Scene& scene) {
  std::vector<EnginePoint> points;
  for (const UserPoint& point : scene.points)
    for (std::size_t k = 0; point.kind == MarkKind::Boundary && k < scene.meshes.size(); ++k)
      if (scene.meshes[k].id == point.mesh) points.push_back({static_cast<int>(k), point.position_mm});
  return points;
}

}  // namespace simplexseg
