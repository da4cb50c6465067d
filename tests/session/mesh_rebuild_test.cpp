// SPDX-License-Identifier: Apache-2.0
#include "session/mesh_rebuild.h"

#include "forces/step_view.h"
#include "image/metrics.h"
#include "image/rasterise.h"
#include "mesh/mesh_geometry.h"
#include "ring_scene.h"
#include "session/mesh_lifecycle.h"
#include "session/mesh_marks.h"

namespace simplexseg {
namespace {

/// Rod along the first axis, 36 mm long, radius 2 mm.
double depth_in_rod(const Eigen::Vector3d& mm) {
  return std::min(2 - std::hypot(mm[1] - 0.2, mm[2] - 0.3), 18 - std::abs(mm[0]));
}

MeshItem item_with_ring_field(const Volume& image) { return item_with_field(image, depth_in_ring, {{14, 0, 0}, 4}); }

TEST(MeshRebuild, ARebuiltMeshHasShapeAndTopologyOfItsField) {
  const Volume image = ring_image();
  MeshItem item = item_with_ring_field(image);
  EXPECT_GT(compare_with_field(item, image).wrong, 1000);
  SimulationParameters simulation = default_simulation_parameters();
  ASSERT_TRUE(rebuild_from_field(item, simulation, image));
  EXPECT_NO_THROW(validate(item.mesh));
  EXPECT_EQ(genus_of(item.mesh), 1);
  EXPECT_EQ(compare_with_field(item, image).wrong, 0);
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

TEST(MeshRebuild, AThinRodKeepsItsLengthAndThickness) {
  const Volume image = image_of(depth_in_rod);
  Mask rod{image.geometry(), std::vector<std::uint8_t>(image.geometry().voxel_count())};
  for (std::size_t v = 0; v < rod.voxels.size(); ++v) rod.voxels[v] = image.voxels<float>()[v] > 100;
  const auto settled_volume = [&](float hold) {
    Scene scene;
    scene.simulation = default_simulation_parameters();
    MeshItem item = item_with_field(image, depth_in_rod, {{0, 0, 0}, 1.4});
    item.id = 1, item.parameters = default_force_parameters();
    set(item.parameters, {"evidence", "hold", hold});
    auto field = std::make_shared<MeshField>(*item.field);
    field->marks = marks_of(scene, item, image);  // so that the field is not solved again
    item.field = field;
    EXPECT_TRUE(rebuild_from_field(item, scene.simulation, image));
    scene.meshes.push_back(item);
    Session session(make_cpu_engine(2), nullptr, 2);
    session.open(scene, image);
    EXPECT_TRUE(session.advance_steps(3000, true).at_rest);
    EXPECT_EQ(session.scene().meshes[0].field, field);
    EXPECT_EQ(session.last_outcome().folded_vertices[0], 0);
    // With the parameter hold at 1, smoothing contracts thin parts.
    EXPECT_GT(dice(rod, rasterise(session.scene().meshes[0].mesh, image.geometry())), hold > 1 ? 0.97 : 0.85);
    return measure(session.scene().meshes[0].mesh).volume_mm3;
  };
  const double with_hold = settled_volume(8), without = settled_volume(1);
  EXPECT_NEAR(with_hold, 4 * M_PI * 36, 45);
  EXPECT_GT(with_hold, 1.03 * without) << "smoothing contracts it";
}

TEST(MeshRebuild, MarksLieOnTheirSideOfTheMeshByHalfAVoxelOrMore) {
  Scene scene = ball_scene();
  set(scene.forces, {"evidence", "source", 0});
  scene.meshes[0].parameters = scene.forces;
  const Volume& image = phantom("sphere", 100, 10).image;
  Session session(make_cpu_engine(2), nullptr, 2);
  session.open(std::move(scene), image);
  const ItemId mesh = session.scene().meshes[0].id;
  session.advance_steps(1000, true);
  // A shallow hole, a bump and a dent.
  const std::vector<std::pair<Eigen::Vector3d, MarkKind>> marks{
      {{8, -9, 0.5}, MarkKind::Outside}, {{1, 20, 0.5}, MarkKind::Inside}, {{-17, -2, 0.5}, MarkKind::Outside}};
  for (const auto& [mm, kind] : marks) session.apply(AddPoint{mesh, mm, kind, 1.5});
  EXPECT_TRUE(session.advance_steps(3000, true).at_rest);
  const MeshItem& ball = session.scene().meshes[0];
  EXPECT_EQ(compare_with_field(ball, image).wrong_marks, 0);
  const Mask mask = rasterise(ball.mesh, image.geometry());
  for (const auto& [mm, kind] : marks) {
    const Eigen::Vector3d at = image.geometry().index_from_world() * mm;
    EXPECT_EQ(mask.voxels[image.offset(std::lround(at[0]), std::lround(at[1]), std::lround(at[2]))] != 0,
              kind == MarkKind::Inside)
        << mm.transpose();
    double nearest = 1e9;
    for (const Eigen::Vector3f& p : ball.mesh.positions) nearest = std::min(nearest, (p.cast<double>() - mm).norm());
    EXPECT_GE(nearest, 0.5) << mm.transpose();
  }
}

TEST(MeshRebuild, AFoldedMeshHasALargerMismatch) {
  const Volume image = ring_image();
  MeshItem item = item_with_ring_field(image);
  ASSERT_TRUE(rebuild_from_field(item, default_simulation_parameters(), image));
  const FieldMismatch sound = compare_with_field(item, image);
  EXPECT_TRUE(sound.matches());
  EXPECT_GT(sound.object, 6000);
  MeshItem folded = item;
  for (int v = 0; v < folded.mesh.vertex_count(); v += 40) {
    const std::array<int, 3>& n = folded.mesh.neighbours[v];
    std::swap(folded.mesh.positions[n[0]], folded.mesh.positions[n[1]]);
  }
  EXPECT_FALSE(compare_with_field(folded, image).matches());
  EXPECT_TRUE(sound.better_than(compare_with_field(folded, image)));
}

TEST(MeshRebuild, ASessionRebuildsASphereAsARing) {
  Session session(make_cpu_engine(2), nullptr, 2);
  const Volume image = ring_image();
  session.open(ring_scene(), image);
  for (const Eigen::Vector3d& mm : ring_marks())
    session.apply(AddPoint{session.scene().meshes[0].id, mm, MarkKind::Inside, 4});
  const Advance done = session.advance_steps(2000, true);
  EXPECT_TRUE(done.at_rest);
  const MeshItem& ring = session.scene().meshes[0];
  EXPECT_EQ(genus_of(ring.mesh), 1);
  EXPECT_TRUE(ring.rebuilt);
  EXPECT_LE(compare_with_field(ring, image).wrong, 8);
  EXPECT_EQ(session.last_outcome().folded_vertices[0], 0);
  session.apply(ResetPose{0});
  EXPECT_FALSE(session.scene().meshes[0].rebuilt);
  EXPECT_EQ(genus_of(session.scene().meshes[0].mesh), 0);
}

// A seed of two voxels starts with few vertices, for which smoothing is stronger than image forces.
TEST(MeshRebuild, ASessionRebuildsACollapsedMesh) {
  const Volume image = phantom("sphere", 100, 4).image;
  Scene scene;
  scene.simulation = default_simulation_parameters();
  MeshItem item;
  item.name = "small", item.seed = {{5, 0, 0}, 2.2 * voxel_mm(image)};
  item.parameters = default_force_parameters();
  scene.meshes.push_back(item);
  Session session(make_cpu_engine(2), nullptr, 2);
  session.open(scene, image);
  EXPECT_TRUE(session.advance_steps(3000, true).at_rest);
  const MeshItem& small = session.scene().meshes[0];
  EXPECT_TRUE(small.rebuilt);
  EXPECT_TRUE(compare_with_field(small, image).matches());
  EXPECT_GT(measure(small.mesh).volume_mm3, 4.0 / 3 * M_PI * std::pow(item.seed.radius_mm, 3));
}

}  // namespace
}  // namespace simplexseg
