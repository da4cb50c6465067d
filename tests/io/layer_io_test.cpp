// SPDX-License-Identifier: Apache-2.0
// Layers in scene files, logs and undo histories, and the files to which they refer.
#include <fstream>

#include "../session/session_fixture.h"
#include "io/platform/files.h"
#include "io/scene/layer_images.h"
#include "io/scene/load_input.h"
#include "io/scene/log_io.h"
#include "io/transform/transform_io.h"
#include "io/volume/volume_checksum.h"
#include "io/volume/volume_io.h"
#include "scene_files.h"

namespace simplexseg {
namespace {

/// Image of 8x8x8 voxels of 2 mm whose values are 10 x + y, by world position.
Volume ramp() {
  VolumeGeometry grid;
  grid.size = {8, 8, 8}, grid.spacing_mm = {2, 2, 2};
  Volume volume(grid, VoxelType::Float32);
  for (int k = 0; k < 8; ++k)
    for (int j = 0; j < 8; ++j)
      for (int i = 0; i < 8; ++i) volume.voxels<float>()[volume.offset(i, j, k)] = static_cast<float>(20 * i + 2 * j);
  return volume;
}

LayerItem layer_of(const std::filesystem::path& path) {
  LayerItem item;
  item.name = "T2 \"Å\"", item.path = path.string();
  item.scale = 1.0 / 3, item.unit = "SUV", item.window = 1.0 / 7, item.level = -1e-9;
  item.opacity = 0.3f, item.colour_map = ColourMap::Magenta, item.visible = false;
  item.transform.affine.matrix().topRows<3>() << 0, -1, 0, 1.0 / 3, 1, 0, 0, -7, 0, 0, 1.25, 1e-12;
  return item;
}

class LayerIo : public SceneIo {};

TEST_F(LayerIo, ASceneKeepsEveryBitOfItsLayers) {
  Scene scene = any_scene();
  scene.volume_path.clear();
  const ItemId last = 16;
  scene.layers = {layer_of("/nowhere/a.nii"), layer_of("/nowhere/b.nii")};
  scene.layers[1].number = 3, scene.layers[1].series = "1.2.3", scene.layers[1].checksum = "crc32-00-1";
  scene.layers[1].transform = {"/nowhere/warp.nii.gz", "crc32-01-2", Eigen::Affine3d::Identity()};
  scene.layers[1].visible = true;
  scene.layers[0].id = last + 1, scene.layers[1].id = last + 2;
  write_scene(folder_ / "scene.json", scene);
  const Scene read = read_scene(folder_ / "scene.json").scene;
  ASSERT_EQ(read.layers.size(), 2u);
  for (std::size_t n = 0; n < 2; ++n) {
    LayerItem expected = scene.layers[n];
    expected.id = read.layers[n].id;
    EXPECT_EQ(read.layers[n], expected) << n;
  }
  EXPECT_LT(read.measurements.back().id, read.layers.front().id);
}

TEST_F(LayerIo, ASceneKeepsTheImagesOfItsMeshes) {
  Scene scene = any_scene();
  scene.volume_path.clear();
  scene.layers = {layer_of("/nowhere/a.nii"), layer_of("/nowhere/b.nii")};
  scene.layers[0].id = 71, scene.layers[1].id = 72;
  scene.meshes[0].images = {72, {0, 71}};
  write_scene(folder_ / "scene.json", scene);
  const Scene read = read_scene(folder_ / "scene.json").scene;
  EXPECT_EQ(read.meshes[0].images, (MeshImages{read.layers[1].id, {0, read.layers[0].id}}));
  EXPECT_TRUE(read.meshes[1].images.is_default());
  std::string text = read_bytes(folder_ / "scene.json");
  const std::size_t at = text.find("\"main\": 2");
  ASSERT_NE(at, std::string::npos);
  text[at + 8] = '3';
  std::ofstream(folder_ / "scene.json") << text;
  EXPECT_THROW(read_scene(folder_ / "scene.json"), Error);
}

TEST_F(LayerIo, ASceneWithoutLayersHasNoKeyForThem) {
  Scene scene = any_scene();
  scene.volume_path.clear();
  write_scene(folder_ / "scene.json", scene);
  EXPECT_EQ(text_of(folder_ / "scene.json").find("layers"), std::string::npos);
}

TEST_F(LayerIo, BadLayersAreRefusedWithTheirPlace) {
  const auto layers = [](const std::string& keys) {
    return scene_with("\"layers\": [{\"name\": \"a\", \"image\": \"a.nii\", \"window\": 1, \"level\": 0" + keys + "}]");
  };
  EXPECT_EQ(refusal(layers("")), "");
  EXPECT_NE(refusal(layers(", \"colour_map\": \"hott\"")).find("'hot'"), std::string::npos);
  EXPECT_NE(refusal(layers(", \"opacity\": 2")).find("layers[0]"), std::string::npos);
  EXPECT_NE(refusal(layers(", \"transform\": {\"affine\": [1, 2]}")).find("12 numbers"), std::string::npos);
  EXPECT_NE(refusal(layers(", \"transform\": {\"affine\": [0,0,0,0,0,0,0,0,0,0,0,0]}")).find("invertible"),
            std::string::npos);
  EXPECT_NE(refusal(layers(", \"colour\": 1")).find("colour"), std::string::npos);
}

TEST_F(LayerIo, LogsKeepEveryBitOfTheirCommands) {
  EditLayer edit{7};
  edit.name = "x", edit.transform = layer_of("y").transform, edit.colour_map = ColourMap::InvertedGrey;
  edit.opacity = 0.1f, edit.window = 1.0 / 3, edit.level = 1e-300, edit.visible = true, edit.continues = true;
  EditLayer name_only{8};
  name_only.name = "z";
  const std::vector<LogEntry> log{
      {1, AddLayer{layer_of("/nowhere/a.nii")}}, {2, edit}, {3, name_only}, {4, RemoveLayer{9}}};
  write_log(folder_ / "log.json", log, 5);
  const LogFile read = read_log(folder_ / "log.json");
  ASSERT_EQ(read.log.size(), log.size());
  EXPECT_EQ(std::get<AddLayer>(read.log[0].command).item, layer_of("/nowhere/a.nii"));
  const auto& again = std::get<EditLayer>(read.log[1].command);
  EXPECT_TRUE(again.layer == 7 && again.name == edit.name && again.transform == edit.transform &&
              again.colour_map == edit.colour_map && again.opacity == edit.opacity && again.window == edit.window &&
              again.level == edit.level && again.visible == edit.visible && again.continues);
  const auto& named = std::get<EditLayer>(read.log[2].command);
  EXPECT_TRUE(named.name == "z" && !named.transform && !named.colour_map && !named.opacity && !named.window &&
              !named.level && !named.visible && !named.continues);
  EXPECT_EQ(std::get<RemoveLayer>(read.log[3].command).layer, 9u);
}

TEST_F(LayerIo, AHistoryRestoresRemovedLayersWithTheirVoxels) {
  write_volume(folder_ / "image.nii", ball_image());
  write_volume(folder_ / "other.nii", ramp());
  LoadedInput input = load_input(folder_ / "image.nii");
  const std::string path = input.scene.volume_path, checksum = input.scene.volume_checksum;
  input.scene = ball_scene();
  input.scene.volume_path = path, input.scene.volume_checksum = checksum;
  Session session(make_cpu_engine(1), nullptr, 1);
  session.open(std::move(input.scene), std::move(input.volume));
  LayerItem item = layer_of(folder_ / "other.nii");
  item.transform = {};
  const ItemId id = session.apply(AddLayer{item});
  EditLayer edit{id};
  edit.level = 3;
  session.apply(edit);
  session.apply(RemoveLayer{id});
  write_scene(folder_ / "scene.json", session.scene(), session.history());

  LoadedInput again = load_input(folder_ / "scene.json");
  EXPECT_TRUE(again.warnings.empty()) << again.warnings.front();
  const LayerImages layers = again.layers;
  Session restored(make_cpu_engine(1), nullptr, 1);
  restored.open(std::move(again.scene), std::move(again.volume), std::move(again.history));
  EXPECT_TRUE(restored.scene().layers.empty());
  restored.apply(Undo{});
  ASSERT_EQ(restored.scene().layers.size(), 1u);
  EXPECT_EQ(restored.scene().layers[0].level, 3);
  EXPECT_NE(layers.image_of(restored.scene().layers[0]), nullptr);
  const ItemId restored_id = restored.scene().layers[0].id;
  restored.apply(Undo{});
  EXPECT_EQ(restored.scene().layers[0].level, item.level);
  EXPECT_EQ(restored.scene().layers[0].id, restored_id);
  restored.apply(Undo{});
  EXPECT_TRUE(restored.scene().layers.empty());
}

TEST_F(LayerIo, ValuesAreThoseOfTheTransformedPoint) {
  write_volume(folder_ / "other.nii", ramp());
  Scene scene;
  scene.layers = {layer_of(folder_ / "other.nii")};
  scene.layers[0].transform = {};
  scene.layers[0].transform.affine.translation() = Eigen::Vector3d(3, 1, 0);
  LayerImages images;
  std::vector<std::string> warnings;
  images.load(scene, folder_, warnings);
  EXPECT_TRUE(warnings.empty());
  // At (1, 2, 5) the layer is sampled at (4, 3, 5): 10 * 4 + 3 = 43, times the scale 1/3.
  ASSERT_TRUE(images.value_at(scene.layers[0], {1, 2, 5}));
  EXPECT_NEAR(*images.value_at(scene.layers[0], {1, 2, 5}), 43.0 / 3, 1e-12);
  EXPECT_EQ(images.value_at(scene.layers[0], {13, 2, 5}), std::nullopt);  // beyond the face at 15 mm
}

TEST_F(LayerIo, ADisplacementFieldIsReadWithItsChecksum) {
  write_volume(folder_ / "other.nii", ramp());
  VolumeGeometry grid;
  grid.size = {4, 4, 4}, grid.spacing_mm = {5, 5, 5};
  write_field(folder_ / "warp.nii.gz", DisplacementField(grid, {64, Eigen::Vector3f(2, 0, 0)}));
  Transform loaded;
  Scene scene;
  scene.layers = {layer_of(folder_ / "other.nii")};
  LayerTransform& transform = scene.layers[0].transform;
  transform = load_layer_transform(folder_ / "warp.nii.gz", loaded);
  EXPECT_FALSE(transform.file.empty());
  transform.affine.translation().y() = 1;  // acts after the field
  LayerImages images;
  std::vector<std::string> warnings;
  images.load(scene, folder_, warnings);
  EXPECT_TRUE(warnings.empty());
  EXPECT_NEAR(images.value_at(scene.layers[0], {4, 4, 4}).value_or(0), (60 + 5) / 3.0, 1e-9);
  write_field(folder_ / "warp.nii.gz", DisplacementField(grid, {64, Eigen::Vector3f(0, 2, 0)}));
  LayerImages changed;
  changed.load(scene, folder_, warnings);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("not the transform with which the scene was saved"), std::string::npos);
  EXPECT_EQ(changed.value_at(scene.layers[0], {4, 4, 4}), std::nullopt);
}

TEST_F(LayerIo, AnAffineTransformFileBecomesTheMatrix) {
  Eigen::Affine3d affine = Eigen::Affine3d::Identity();
  affine.translation() = Eigen::Vector3d(1.0 / 3, -5, 2);
  write_transform(folder_ / "t.tfm", Transform(affine));
  Transform loaded;
  const LayerTransform transform = load_layer_transform(folder_ / "t.tfm", loaded);
  EXPECT_TRUE(transform.file.empty());
  EXPECT_EQ(transform.affine.matrix(), affine.matrix());
}

TEST_F(LayerIo, AMissingOrChangedFileAddsOneLineAndKeepsTheScene) {
  write_volume(folder_ / "image.nii", ball_image());
  const std::string scene = scene_with(
      "\"volume\": \"image.nii\", \"layers\": [{\"name\": \"PET\", \"image\": \"gone.nii\", \"window\": 1, \"level\": "
      "0}]");
  const LoadedInput input = load_input(write("scene.json", scene));
  ASSERT_EQ(input.warnings.size(), 1u);
  EXPECT_NE(input.warnings[0].find("layer 'PET' is not shown"), std::string::npos);
  EXPECT_NE(input.warnings[0].find("gone.nii"), std::string::npos);
  EXPECT_EQ(input.warnings[0].find('\n'), std::string::npos);
  EXPECT_EQ(input.scene.layers.size(), 1u);
  EXPECT_EQ(input.layers.image_of(input.scene.layers[0]), nullptr);
  write_volume(folder_ / "gone.nii", ramp());
  Scene other = input.scene;
  other.layers[0].checksum = "crc32-00000000-1";
  LayerImages images;
  std::vector<std::string> warnings;
  images.load(other, folder_, warnings);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("not the image with which the scene was saved"), std::string::npos);
  EXPECT_NE(images.image_of(other.layers[0]), nullptr);
}

}  // namespace
}  // namespace simplexseg
