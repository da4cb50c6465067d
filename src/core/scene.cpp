// SPDX-License-Identifier: Apache-2.0
#include "core/scene.h"

#include <algorithm>

namespace simplexseg {
namespace {

template <class Items, class Test>
auto find_in(Items& items, Test test) {
  const auto found = std::find_if(items.begin(), items.end(), test);
  return found == items.end() ? nullptr : &*found;
}

}  // namespace

bool is_finest(const MeshItem& item, const SimulationParameters& simulation, double voxel_mm) {
  const int wanted = item.final_vertices > 0 ? item.final_vertices : static_cast<int>(simulation.final_vertices + 0.5f);
  if (item.mesh.vertex_count() >= wanted) return true;
  return item.final_vertices == 0 && measure(item.mesh).mean_edge_mm < simulation.finest_edge * voxel_mm;
}

const MeshItem* Scene::find_mesh(ItemId id) const {
  return find_in(meshes, [id](const MeshItem& item) { return item.id == id; });
}

MeshItem* Scene::find_mesh(ItemId id) {
  return find_in(meshes, [id](const MeshItem& item) { return item.id == id; });
}

const MeshItem* Scene::find_mesh(const std::string& name) const {
  return find_in(meshes, [&name](const MeshItem& item) { return item.name == name; });
}

const AttractionPoint* Scene::find_point(ItemId id) const {
  return find_in(points, [id](const AttractionPoint& point) { return point.id == id; });
}

}  // namespace simplexseg
