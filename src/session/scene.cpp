// SPDX-License-Identifier: Apache-2.0
#include "session/scene.h"

#include <algorithm>

#include "mesh/mesh_geometry.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

template <class Items, class Test>
auto find_in(Items& items, Test test) {
  const auto found = std::find_if(items.begin(), items.end(), test);
  return found == items.end() ? nullptr : &*found;
}

}  // namespace

static bool has_enough_vertices(const MeshItem& item, const SimulationParameters& simulation) {
  if (item.rebuilt) return true;
  const int final_vertices =
      item.final_vertices > 0 ? item.final_vertices : static_cast<int>(simulation.final_vertices + 0.5f);
  return item.mesh.vertex_count() >= final_vertices;
}

bool is_finest(const MeshItem& item, const SimulationParameters& simulation, double voxel_mm) {
  return has_enough_vertices(item, simulation) ||
         is_finest(item, simulation, voxel_mm,
                   item.edge_mm > 0 ? item.edge_mm : mean_edge_mm(item.mesh.positions, item.mesh.neighbours));
}

bool is_finest(const MeshItem& item, const SimulationParameters& simulation, double voxel_mm, double mean_edge_mm) {
  return has_enough_vertices(item, simulation) ||
         (item.final_vertices == 0 && mean_edge_mm < simulation.finest_edge * voxel_mm);
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

std::vector<Eigen::Vector3d> UserPoint::vertices_mm() const {
  std::vector<Eigen::Vector3d> vertices{position_mm};
  for (const Eigen::Vector3d& offset : path_mm) vertices.emplace_back(position_mm + offset);
  return vertices;
}

const UserPoint* Scene::find_point(ItemId id) const {
  return find_in(points, [id](const UserPoint& point) { return point.id == id; });
}

const Measurement* Scene::find_measurement(ItemId id) const {
  return find_in(measurements, [id](const Measurement& measurement) { return measurement.id == id; });
}

const LayerItem* Scene::find_layer(ItemId id) const {
  return find_in(layers, [id](const LayerItem& layer) { return layer.id == id; });
}

}  // namespace simplexseg
