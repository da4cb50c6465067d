// SPDX-License-Identifier: Apache-2.0
// Filters of layers and of the volume in scene files, logs and undo histories.
#include <cstdlib>

#include "../session/session_fixture.h"
#include "io/registration/filters.h"
#include "io/scene/layer_images.h"
#include "io/scene/load_input.h"
#include "io/scene/log_io.h"
#include "io/volume/volume_checksum.h"
#include "io/volume/volume_io.h"
#include "scene_files.h"

namespace simplexseg {
namespace {

Preprocessing two_filters() { return {{{FilterKind::Uptake, {1.0 / 3}}, {FilterKind::Uptake, {7}}}, ""}; }

class PreprocessingIo : public SceneIo {
 protected:
  /// Scene of the ball whose volume has two filters.
  std::filesystem::path write_filtered_scene(const std::string& checksum = {}) const {
    write_volume(folder_ / "image.nii", ball_image());
    Scene scene = ball_scene();
    scene.volume_path = (folder_ / "image.nii").string();
    scene.volume_preprocessing = two_filters();
    scene.volume_preprocessing.checksum = checksum;
    write_scene(folder_ / "scene.json", scene);
    return folder_ / "scene.json";
  }
};

TEST_F(PreprocessingIo, ScenesAndLogsKeepEveryBit) {
  Preprocessing all{{{FilterKind::BiasField, {2, 3, 17}},
                     {FilterKind::Diffusion, {9, 1.0 / 3}},
                     {FilterKind::Median, {2}},
                     {FilterKind::Isotropic, {1.0 / 7}}},
                    "crc32-01-2"};
  Scene scene = any_scene();
  scene.volume_path.clear();
  scene.layers.resize(2);
  for (LayerItem& layer : scene.layers) layer.name = "a", layer.path = "/nowhere/a.nii";
  scene.layers[0].preprocessing = all;
  scene.volume_preprocessing = {{all.filters[0], all.filters[2]}, "crc32-03-4"};
  write_scene(folder_ / "scene.json", scene);
  const Scene read = read_scene(folder_ / "scene.json").scene;
  EXPECT_EQ(read.volume_preprocessing, scene.volume_preprocessing);
  EXPECT_EQ(read.layers[0].preprocessing, all);
  EXPECT_TRUE(read.layers[1].preprocessing.filters.empty());
  EditLayer edit{7};
  edit.preprocessing = all;
  write_log(folder_ / "log.json", {{1, edit}, {2, FilterVolume{scene.volume_preprocessing}}, {3, FilterVolume{}}}, 5);
  const LogFile log = read_log(folder_ / "log.json");
  EXPECT_EQ(std::get<EditLayer>(log.log[0].command).preprocessing, all);
  EXPECT_EQ(std::get<FilterVolume>(log.log[1].command).preprocessing, scene.volume_preprocessing);
  EXPECT_EQ(std::get<FilterVolume>(log.log[2].command).preprocessing, Preprocessing{});
}

TEST_F(PreprocessingIo, BadFiltersAreRefusedWithTheirPlace) {
  const auto filters = [](const std::string& list) {
    return scene_with("\"preprocessing\": {\"filters\": [" + list + "]}");
  };
  EXPECT_EQ(refusal(filters("{\"name\": \"n4\"}")), "");
  EXPECT_NE(refusal(filters("{\"name\": \"n5\"}")).find("'n4'"), std::string::npos);
  EXPECT_NE(refusal(filters("{\"name\": \"median\", \"radius\": 9}")).find("radius"), std::string::npos);
  EXPECT_NE(refusal(filters("{\"name\": \"median\", \"radius\": 1.5}")).find("whole"), std::string::npos);
  EXPECT_NE(refusal(filters("{\"name\": \"n4\"}, {\"name\": \"median\", \"shrink\": 2}")).find("filters[1]"),
            std::string::npos);
}

TEST_F(PreprocessingIo, AnOpenedSceneHasTheFilteredVolume) {
  const LoadedInput input = load_input(write_filtered_scene());
  EXPECT_TRUE(input.warnings.empty()) << input.warnings.front();
  EXPECT_EQ(input.volume.value(30, 31, 32), 7 * static_cast<float>(ball_image().value(30, 31, 32) / 3));
  EXPECT_EQ(input.scene.volume_checksum, checksum_of(ball_image()));  // of the file
  // A change of the result is reported, as after an update of ITK.
  EXPECT_TRUE(load_input(write_filtered_scene(checksum_of(input.volume))).warnings.empty());
  const LoadedInput other = load_input(write_filtered_scene("crc32-00000000-1"));
  ASSERT_EQ(other.warnings.size(), 1u);
  EXPECT_NE(other.warnings[0].find("give other values"), std::string::npos) << other.warnings[0];
}

TEST_F(PreprocessingIo, AHistoryRestoresTheVolumeWithOtherFilters) {
  LoadedInput input = load_input(write_filtered_scene());
  Session session(make_cpu_engine(1), nullptr, 1);
  session.open(std::move(input.scene), std::move(input.volume));
  add_filters(session, std::move(input.volumes));
  session.apply(FilterVolume{});
  const Preprocessing third{{{FilterKind::Uptake, {2}}}, ""};
  session.apply(FilterVolume{third});
  session.apply(FilterVolume{two_filters()});
  write_scene(folder_ / "scene.json", session.scene(), session.history());
  LoadedInput again = load_input(folder_ / "scene.json");
  EXPECT_TRUE(again.warnings.empty()) << again.warnings.front();
  Session restored(make_cpu_engine(1), nullptr, 1);
  restored.open(std::move(again.scene), std::move(again.volume), std::move(again.history));
  for (FilteredVolume& one : again.volumes) restored.add_volume(std::move(one));  // nothing is computed any more
  restored.apply(Undo{});
  EXPECT_EQ(restored.volume().value(30, 31, 32), 2 * static_cast<float>(ball_image().value(30, 31, 32)));
  restored.apply(Undo{});
  EXPECT_EQ(restored.volume().value(30, 31, 32), ball_image().value(30, 31, 32));
  restored.apply(Undo{});
  EXPECT_EQ(restored.volume().value(30, 31, 32), 7 * static_cast<float>(ball_image().value(30, 31, 32) / 3));
}

TEST_F(PreprocessingIo, LayersAreFilteredFromTheLongestKnownResult) {
  write_volume(folder_ / "image.nii", ball_image());
  Scene scene;
  scene.layers.resize(1);
  LayerItem& layer = scene.layers[0];
  layer.name = "a", layer.path = (folder_ / "image.nii").string(), layer.preprocessing = two_filters();
  LayerImages images;
  std::vector<std::string> warnings;
  images.load(scene, folder_, warnings);
  EXPECT_TRUE(warnings.empty());
  LayerItem source = layer, first = layer;
  source.preprocessing = {}, first.preprocessing.filters.pop_back();
  ASSERT_TRUE(images.image_of(layer) && images.image_of(source) && images.image_of(first));
  EXPECT_EQ(images.image_of(source)->value(9, 9, 9), ball_image().value(9, 9, 9));
  EXPECT_EQ(images.image_of(layer)->value(9, 9, 9), static_cast<float>(7 * images.image_of(first)->value(9, 9, 9)));
  // Only the last filter is computed: the others keep their voxels.
  const void* const voxels = images.image_of(first)->data();
  LayerItem more = layer;
  more.preprocessing.filters.push_back({FilterKind::Uptake, {2}});
  const std::string checksum = images.add_filtered(more);
  EXPECT_EQ(checksum, checksum_of(*images.image_of(more)));
  EXPECT_EQ(images.image_of(first)->data(), voxels);
  layer.preprocessing.checksum = "crc32-00000000-1";
  LayerImages other;
  other.load(scene, folder_, warnings);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("give other values"), std::string::npos);
}

TEST_F(PreprocessingIo, AMissingProgramIsNamedInOneLine) {
  write_volume(folder_ / "image.nii", ball_image());
  ::setenv("SIMPLEXSEG_REGISTER", (folder_ / "missing").c_str(), 1);
  Scene scene = ball_scene();
  scene.volume_path = (folder_ / "image.nii").string();
  scene.layers.resize(1);
  scene.layers[0].name = "a", scene.layers[0].path = scene.volume_path;
  scene.layers[0].preprocessing.filters = {{FilterKind::Median, {1}}};
  write_scene(folder_ / "scene.json", scene);
  const LoadedInput input = load_input(folder_ / "scene.json");
  ASSERT_EQ(input.warnings.size(), 1u);
  EXPECT_NE(input.warnings[0].find("layer 'a' is not shown"), std::string::npos) << input.warnings[0];
  EXPECT_NE(input.warnings[0].find("simplexseg-register"), std::string::npos) << input.warnings[0];
  EXPECT_EQ(input.warnings[0].find('\n'), std::string::npos);
  scene.layers.clear();
  scene.volume_preprocessing.filters = {{FilterKind::Median, {1}}};
  write_scene(folder_ / "scene.json", scene);
  std::string refused;
  try {
    load_input(folder_ / "scene.json");
  } catch (const Error& error) {
    refused = error.what();
  }
  ::unsetenv("SIMPLEXSEG_REGISTER");
  EXPECT_NE(refused.find("simplexseg-register"), std::string::npos) << refused;
  EXPECT_EQ(refused.find('\n'), std::string::npos) << refused;
}

}  // namespace
}  // namespace simplexseg
