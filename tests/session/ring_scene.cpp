// SPDX-License-Identifier: Apache-2.0
#include "ring_scene.h"

#include <cmath>

#include "forces/step_view.h"
#include "mesh/mesh_geometry.h"
#include "session/mesh_lifecycle.h"
#include "session/mesh_marks.h"

namespace simplexseg {

double depth_in_ring(const Eigen::Vector3d& mm) { return 5 - std::hypot(std::hypot(mm[0], mm[1]) - 14, mm[2]); }

Volume image_of(Depth depth) {
  const Volume& like = phantom("flat").image;
  Volume image(like.geometry(), VoxelType::Float32);
  const auto [ni, nj, nk] = like.geometry().size;
  for (int k = 0; k < nk; ++k)
    for (int j = 0; j < nj; ++j)
      for (int i = 0; i < ni; ++i) {
        const Eigen::Vector3d mm = like.geometry().world_from_index() * Eigen::Vector3d(i, j, k);
        image.voxels<float>()[image.offset(i, j, k)] =
            depth(mm) > 0 ? 150.0f : 50.0f + static_cast<float>((i * 7 + j * 13 + k * 5) % 11);
      }
  return image;
}
Volume ring_image() { return image_of(depth_in_ring); }

MeshItem item_with_field(const Volume& image, Depth depth, const Seed& seed) {
  MeshItem item;
  item.name = "object", item.seed = seed;
  auto field = std::make_shared<MeshField>();
  field->box.size = image.geometry().size;
  for (int k = 0; k < field->box.size[2]; ++k)
    for (int j = 0; j < field->box.size[1]; ++j)
      for (int i = 0; i < field->box.size[0]; ++i) {
        const double in = depth(image.geometry().world_from_index() * Eigen::Vector3d(i, j, k));
        field->values.push_back(static_cast<std::uint16_t>(kFieldScale / (1 + std::exp(-2 * in))));
      }
  item.field = field;
  complete(item, default_simulation_parameters(), image);
  return item;
}

Scene ring_scene() {
  Scene scene;
  scene.simulation = default_simulation_parameters();
  MeshItem item;
  item.name = "ring", item.seed = {{14, 0, 0}, 4}, item.parameters = default_force_parameters();
  set(item.parameters, {"evidence", "source", 0});
  scene.meshes.push_back(item);
  return scene;
}
Scene solved_ring_scene() {
  static const Scene solved = [] {
    Scene scene = ring_scene();
    MeshItem& item = scene.meshes[0];
    item.id = 1;
    auto field = std::make_shared<MeshField>(*item_with_field(ring_image(), depth_in_ring, item.seed).field);
    field->marks = marks_of(scene, item, ring_image());
    item.field = field;
    return scene;
  }();
  return solved;
}
std::vector<Eigen::Vector3d> ring_marks() { return {{-14, 0, 0}, {0, 14, 0}, {0, -14, 0}}; }

int genus_of(const SimplexMesh& mesh) { return 1 - (cells_of(mesh).count() - mesh.vertex_count() / 2) / 2; }

}  // namespace simplexseg
