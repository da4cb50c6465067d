// SPDX-License-Identifier: Apache-2.0
#include "scene_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

TEST_F(SceneIo, RoundTripKeepsEveryBit) {
  const Scene before = any_scene();
  Scene named = before;
  named.volume_path.clear();  // the volume would have to exist to be read again
  write_scene(folder_ / "Übung.json", named);
  const Scene after = read_scene(folder_ / "Übung.json").scene;

  EXPECT_TRUE(same_bits(before.simulation, after.simulation));
  EXPECT_TRUE(same_bits(before.forces, after.forces));
  EXPECT_EQ(before.steps, after.steps);
  ASSERT_EQ(before.meshes.size(), after.meshes.size());
  for (std::size_t m = 0; m < before.meshes.size(); ++m) {
    const MeshItem &a = before.meshes[m], &b = after.meshes[m];
    SCOPED_TRACE(a.name);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.colour, b.colour);
    EXPECT_EQ(a.visible, b.visible);
    EXPECT_EQ(a.label, b.label);
    EXPECT_EQ(a.code, b.code);
    EXPECT_TRUE(same_bits(a.seed.centre_mm, b.seed.centre_mm));
    EXPECT_EQ(a.seed.radius_mm, b.seed.radius_mm);
    EXPECT_EQ(a.reference->labels, b.reference->labels);
    EXPECT_EQ(a.reference->value, b.reference->value);
    EXPECT_TRUE(same_bits(a.parameters, b.parameters));
    EXPECT_TRUE(same_bits(a.mesh.positions, b.mesh.positions));
    EXPECT_TRUE(same_bits(a.mesh.neighbours, b.mesh.neighbours));
    EXPECT_TRUE(same_bits(a.previous, b.previous));
    EXPECT_TRUE(same_bits(a.shape, b.shape));
    EXPECT_TRUE(same_bits(a.profiles, b.profiles));
    EXPECT_TRUE(same_bits(a.region, b.region));
    EXPECT_EQ(a.steps_at_level, b.steps_at_level);
    EXPECT_EQ(a.final_vertices, b.final_vertices);
  }
  EXPECT_EQ(after.labels.preset, before.labels.preset);
  EXPECT_EQ(after.labels.by_name, before.labels.by_name);
  ASSERT_EQ(after.points.size(), before.points.size());
  for (std::size_t p = 0; p < before.points.size(); ++p) {
    EXPECT_TRUE(same_bits(before.points[p].position_mm, after.points[p].position_mm));
    EXPECT_EQ(before.points[p].path_mm, after.points[p].path_mm);
    EXPECT_EQ(before.points[p].brush, after.points[p].brush);
    EXPECT_EQ(before.points[p].edit, after.points[p].edit);
    EXPECT_EQ(before.points[p].continues, after.points[p].continues);
    EXPECT_EQ(before.points[p].lasso_normal, after.points[p].lasso_normal);
    EXPECT_EQ(before.find_mesh(before.points[p].mesh)->name, after.find_mesh(after.points[p].mesh)->name);
    ASSERT_EQ(before.points[p].voxels != nullptr, after.points[p].voxels != nullptr);
    if (!before.points[p].voxels) continue;
    const PaintVoxels &a = *before.points[p].voxels, &b = *after.points[p].voxels;
    EXPECT_EQ(a.voxels, b.voxels);
    EXPECT_EQ(a.box.size, b.box.size);
    EXPECT_EQ(a.box.spacing_mm, b.box.spacing_mm);
    EXPECT_EQ(a.box.origin_mm, b.box.origin_mm);
    EXPECT_EQ(a.box.direction, b.box.direction);
  }
  ASSERT_EQ(after.measurements.size(), before.measurements.size());
  for (std::size_t m = 0; m < before.measurements.size(); ++m) {
    Measurement expected = before.measurements[m];
    expected.id = after.measurements[m].id;
    EXPECT_EQ(after.measurements[m], expected);
  }
  // Saving the scene again gives the same text.
  write_scene(folder_ / "again.json", after);
  std::string first = text_of(folder_ / "Übung.json"), second = text_of(folder_ / "again.json");
  for (const auto& [from, to] : {std::pair{"Übung", "X"}, {"again", "X"}, {"mesh-3", "mesh-1"}, {"mesh-4", "mesh-2"}})
    for (std::string* text : {&first, &second})
      for (std::size_t at; (at = text->find(from)) != std::string::npos;) text->replace(at, std::strlen(from), to);
  EXPECT_EQ(first, second);
}

TEST_F(SceneIo, ASceneIsWrittenToAPathWithoutAFolder) {
  Scene scene = any_scene();
  scene.volume_path = (folder_ / "volume.nii").string();
  write("volume.nii", "");
  const fs::path before = fs::current_path();
  fs::current_path(folder_);
  EXPECT_NO_THROW(write_scene("scene.json", scene));
  fs::current_path(before);
  EXPECT_NE(text_of(folder_ / "scene.json").find("\"volume.nii\""), std::string::npos);  // relative path
}

TEST_F(SceneIo, AStateOfAnotherPoseOrATruncatedStateIsRejected) {
  Scene scene = any_scene();
  scene.volume_path.clear();
  write_scene(folder_ / "scene.json", scene);
  const std::string state = text_of(folder_ / "scene.mesh-3.state");
  write("scene.mesh-3.state", text_of(folder_ / "scene.mesh-4.state"));
  EXPECT_THROW(read_scene(folder_ / "scene.json"), Error);
  for (const std::size_t length : {std::size_t{0}, std::size_t{10}, state.size() / 2, state.size() - 1}) {
    write("scene.mesh-3.state", state.substr(0, length));
    EXPECT_THROW(read_scene(folder_ / "scene.json"), Error) << length;
  }
  write("scene.mesh-3.state", state);
  EXPECT_NO_THROW(read_scene(folder_ / "scene.json"));
}

TEST_F(SceneIo, AFailedWriteKeepsTheOldFiles) {
  Scene scene = any_scene();
  scene.volume_path.clear();
  write_scene(folder_ / "scene.json", scene);
  const std::string before = text_of(folder_ / "scene.json"), pose = text_of(folder_ / "scene.mesh-3.ply");
  Scene broken = scene;
  broken.meshes[0].mesh.positions[0] *= 1.5f;
  broken.meshes[1].mesh.positions[0].x() = std::nanf("");
  EXPECT_THROW(write_scene(folder_ / "scene.json", broken), Error);
  broken = scene;
  broken.meshes[1].name = broken.meshes[0].name;
  EXPECT_THROW(write_scene(folder_ / "scene.json", broken), Error);
  EXPECT_EQ(text_of(folder_ / "scene.json"), before);
  EXPECT_TRUE(text_of(folder_ / "scene.mesh-3.ply") == pose);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 5);  // no temporary files remain
  EXPECT_THROW(write_scene(folder_ / "none" / "scene.json", scene), Error);
  EXPECT_THROW(write_scene(folder_, scene), Error);
}

}  // namespace
}  // namespace simplexseg
