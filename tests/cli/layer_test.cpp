// SPDX-License-Identifier: Apache-2.0
// Layers and filters of scenes on the command line: subcommand layer, pictures, runs and replays.
#include "app/slice_picture.h"
#include "cli_fixture.h"
#include "image/transform.h"
#include "io/scene/layer_file.h"
#include "io/scene/scene_io.h"
#include "io/transform/transform_io.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

class LayerCommand : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    make_scene();
    write_volume(path("other.nii"), read_volume(path("image.nii.gz")));
  }
};

TEST_F(LayerCommand, AddsAnImageWithItsTransformAndDisplay) {
  Eigen::Affine3d shift = Eigen::Affine3d::Identity();
  shift.translation() = Eigen::Vector3d(1.0 / 3, 0, -4);
  write_transform(path("shift.tfm"), Transform(shift));
  succeed({"layer", path("scene.json"), path("other.nii"), path("first.json")});
  succeed({"layer", path("first.json"), path("other.nii"), path("second.json"), "--transform", path("shift.tfm"),
           "--name", "T2", "--colours", "green", "--opacity", "0.25", "--window", "7", "--level", "3"});
  const Scene scene = read_scene(path("second.json")).scene;
  ASSERT_EQ(scene.layers.size(), 2u);
  EXPECT_EQ(scene.layers[0].name, "other");
  EXPECT_TRUE(scene.layers[0].transform.is_identity());
  const LayerItem& layer = scene.layers[1];
  EXPECT_EQ(layer.name, "T2");
  EXPECT_EQ(layer.transform.affine.matrix(), shift.matrix());
  EXPECT_TRUE(layer.colour_map == ColourMap::Green && layer.opacity == 0.25f && layer.window == 7 && layer.level == 3);
  EXPECT_EQ(scene.meshes.size(), 1u);
}

TEST_F(LayerCommand, WrongInputsAreRefused) {
  const auto refused = [&](const Arguments& arguments, const std::string& part) {
    const Outcome result = call(arguments);
    EXPECT_EQ(result.status, 2);
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
    EXPECT_FALSE(exists("out.json"));
  };
  refused({"layer", path("scene.json"), path("missing.nii"), path("out.json")}, "missing.nii");
  refused({"layer", path("scene.json"), path("other.nii"), path("scene.json")}, "scene.json");
  refused({"layer", path("scene.json"), path("other.nii"), path("out.nii")}, "out.nii");
  refused({"layer", path("scene.json"), path("other.nii"), path("out.json"), "--colours", "blue"}, "blue");
  refused({"layer", path("scene.json"), path("other.nii"), path("out.json"), "--window", "0"}, "window");
}

TEST_F(LayerCommand, PicturesShowTheVisibleLayers) {
  succeed({"layer", path("scene.json"), path("other.nii"), path("layered.json"), "--colours", "green"});
  for (const char* name : {"scene", "layered"})
    succeed({"run", path(name + std::string(".json")), "--steps", "0", "--backend", "cpu", "--picture",
             path(name + std::string(".png"))});
  EXPECT_NE(text_of("scene.png"), text_of("layered.png"));
  // The colours of a layer that covers the volume are those of its map.
  LayerFile layer = read_layer(path("other.nii"));
  Scene scene;
  layer.item.opacity = 1, layer.item.window = 1, layer.item.level = -1000;  // all values have the last colour
  layer.item.colour_map = ColourMap::Magenta;
  scene.layers = {layer.item};
  LayerImages images;
  images.add_image(layer.item, layer.image);
  const LayerPicture picture(scene, images);
  const Eigen::Vector3d centre = layer.image->geometry().centre_mm();
  EXPECT_EQ(picture.over({9, 9, 9}, centre), (Colour{255, 0, 255}));
  EXPECT_EQ(picture.over({9, 9, 9}, centre + Eigen::Vector3d(999, 0, 0)), (Colour{9, 9, 9}));
  scene.layers[0].opacity = 0.5f;
  EXPECT_EQ(LayerPicture(scene, images).over({9, 9, 9}, centre), (Colour{132, 5, 132}));
  scene.layers[0].visible = false;
  EXPECT_EQ(LayerPicture(scene, images).over({9, 9, 9}, centre), (Colour{9, 9, 9}));
}

TEST_F(LayerCommand, AFilteredVolumeIsRunAndReplayed) {
  nlohmann::json scene = scene_json();
  scene["preprocessing"] = {{"filters", {{{"name", "suv"}, {"factor", 2}}}}};
  write_scene("filtered.json", scene);
  scene["measurements"] = {{{"kind", "ellipse"}, {"name", "e"}, {"points_mm", {{0, 0, 0}, {6, 0, 0}, {0, 6, 0}}}}};
  write_scene("measured.json", scene);
  scene.erase("preprocessing");
  write_scene("plain.json", scene);
  const auto table = [&](const char* name) { return succeed({"measure", path(name)}).out; };
  EXPECT_NE(table("measured.json"), table("plain.json"));
  write("log.json", R"({"simplexseg_log": 1, "entries": [
    {"after_steps": 5, "command": "filter_volume", "preprocessing": {"filters": [{"name": "suv", "factor": 3}]}},
    {"after_steps": 5, "command": "undo"}, {"after_steps": 0, "command": "redo"}], "trailing_steps": 5})");
  for (const char* name : {"first", "second"})
    succeed({"run", path("filtered.json"), "--backend", "cpu", "--replay", path("log.json"), "--save",
             path(name + std::string(".json"))});
  EXPECT_EQ(json_of("first.json")["preprocessing"]["filters"][0]["factor"], 3);
  const std::vector<MeshItem> first = read_scene(path("first.json")).scene.meshes;
  EXPECT_EQ(first.at(0).mesh.positions, read_scene(path("second.json")).scene.meshes.at(0).mesh.positions);
}

TEST_F(LayerCommand, UptakeValuesNeedAFactorOrPet) {
  succeed({"filter", path("image.nii.gz"), path("scaled.nii"), "--suv", "--suv-factor", "0.5"});
  const Volume image = read_volume(path("image.nii.gz")), scaled = read_volume(path("scaled.nii"));
  EXPECT_EQ(scaled.value(12, 12, 12), static_cast<float>(0.5 * image.value(12, 12, 12)));
  const Outcome refused = call({"filter", path("image.nii.gz"), path("x.nii"), "--suv"});
  EXPECT_NE(refused.status, 0);
  EXPECT_NE(refused.err.find("factor"), std::string::npos) << refused.err;
  EXPECT_FALSE(exists("x.nii"));
}

}  // namespace
}  // namespace simplexseg
