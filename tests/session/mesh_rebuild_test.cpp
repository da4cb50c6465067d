// SPDX-License-Identifier: Apache-2.0
#include "session/mesh_rebuild.h"

#include "forces/step_view.h"
#include "image/rasterise.h"
#include "mesh/mesh_geometry.h"
#include "session/mesh_life.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

/// A ring: bright, radius 14 mm, its tube 5 mm.
double depth_in_ring(const Eigen::Vector3d& mm) { return 5 - std::hypot(std::hypot(mm[0], mm[1]) - 14, mm[2]); }

Volume ring_image() {
  const Volume& like = phantom("flat").image;
  Volume image(like.geometry(), VoxelType::Float32);
  const auto [ni, nj, nk] = like.geometry().size;
  for (int k = 0; k < nk; ++k)
    for (int j = 0; j < nj; ++j)
      for (int i = 0; i < ni; ++i) {
        const Eigen::Vector3d mm = like.geometry().world_from_index() * Eigen::Vector3d(i, j, k);
        image.voxels<float>()[image.offset(i, j, k)] =
            depth_in_ring(mm) > 0 ? 150.0f : 50.0f + static_cast<float>((i * 7 + j * 13 + k * 5) % 11);
      }
  return image;
}
MeshItem item_with_ring_field(const Volume& image) {
  MeshItem item;
  item.name = "ring", item.seed = {{14, 0, 0}, 4};
  auto field = std::make_shared<MeshField>();
  field->box.size = image.geometry().size;
  for (int k = 0; k < field->box.size[2]; ++k)
    for (int j = 0; j < field->box.size[1]; ++j)
      for (int i = 0; i < field->box.size[0]; ++i) {
        const double depth = depth_in_ring(image.geometry().world_from_index() * Eigen::Vector3d(i, j, k));
        field->values.push_back(static_cast<std::uint16_t>(kFieldScale / (1 + std::exp(-2 * depth))));
      }
  item.field = field;
  complete(item, default_simulation_parameters(), image);
  return item;
}
int genus_of(const SimplexMesh& mesh) { return 1 - (cells_of(mesh).count() - mesh.vertex_count() / 2) / 2; }

TEST(MeshRebuild, AMeshMadeOfItsFieldHasItsShapeAndItsTopology) {
  const Volume image = ring_image();
  MeshItem item = item_with_ring_field(image);
  EXPECT_GT(deep_disagreement(item, image), 1000);
  SimulationParameters simulation = default_simulation_parameters();
  ASSERT_TRUE(rebuild_from_field(item, simulation, image));
  EXPECT_NO_THROW(validate(item.mesh));
  EXPECT_EQ(genus_of(item.mesh), 1);
  EXPECT_EQ(deep_disagreement(item, image), 0);
  EXPECT_NEAR(measure(item.mesh).volume_mm3, 2 * M_PI * 14 * M_PI * 25, 0.08 * 6900);
  EXPECT_EQ(item.previous.size(), item.mesh.positions.size());
  EXPECT_EQ(item.shape.size(), item.mesh.positions.size());
  EXPECT_TRUE(is_finest(item, simulation, 1)) << "it is not refined further";
  const int many = item.mesh.vertex_count();
  simulation.final_vertices = 1000;
  ASSERT_TRUE(rebuild_from_field(item, simulation, image));
  EXPECT_LE(item.mesh.vertex_count(), 2000);
  EXPECT_LT(item.mesh.vertex_count(), many);
}

TEST(MeshRebuild, AFieldWithoutAnObjectMakesNoMesh) {
  const Volume image = ring_image();
  MeshItem item = item_with_ring_field(image);
  auto nothing = std::make_shared<MeshField>(*item.field);
  std::fill(nothing->values.begin(), nothing->values.end(), 0);
  item.field = nothing;
  const int before = item.mesh.vertex_count();
  EXPECT_FALSE(rebuild_from_field(item, default_simulation_parameters(), image));
  EXPECT_EQ(item.mesh.vertex_count(), before);
}

TEST(MeshRebuild, ASessionMakesARingOfASphereThatCannotGrowIntoOne) {
  Scene scene;
  scene.simulation = default_simulation_parameters();
  MeshItem item;
  item.name = "ring", item.seed = {{14, 0, 0}, 4}, item.parameters = default_force_parameters();
  set(item.parameters, {"evidence", "source", 0});
  scene.meshes.push_back(item);
  Session session(make_cpu_engine(2), nullptr, 2);
  const Volume image = ring_image();
  session.open(scene, image);
  // A user's marks, so that it is the mesh alone that is tried.
  for (const Eigen::Vector3d& mm : {Eigen::Vector3d(-14, 0, 0), Eigen::Vector3d(0, 14, 0), Eigen::Vector3d(0, -14, 0)})
    session.apply(AddPoint{session.scene().meshes[0].id, mm, MarkKind::Inside, 4});
  const Advance done = session.advance_steps(2000, true);
  EXPECT_TRUE(done.at_rest);
  const MeshItem& ring = session.scene().meshes[0];
  EXPECT_EQ(genus_of(ring.mesh), 1);
  EXPECT_TRUE(ring.rebuilt);
  EXPECT_LE(deep_disagreement(ring, image), 8);
  EXPECT_EQ(session.last_outcome().folded_vertices[0], 0);
  session.apply(ResetPose{0});
  EXPECT_FALSE(session.scene().meshes[0].rebuilt);
  EXPECT_EQ(genus_of(session.scene().meshes[0].mesh), 0);
}

}  // namespace
}  // namespace simplexseg
