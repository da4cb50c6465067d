// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>

#include "core/number_text.h"
#include "io/platform/data_path.h"
#include "io/scene/set_by_path.h"
#include "scene_files.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

TEST_F(SceneIo, ReadsEveryKey) {
  const Scene scene = read_text(scene_with(R"(
    "simulation": {"damping": 0.25, "limit_timestep": "off", "refresh_interval": 5},
    "forces": {"gradient": {"weight": 2, "object": "dark"}},
    "meshes": [
      {"name": "brain", "sphere": {"centre_mm": [1, -2, 3.5], "radius_mm": 40}, "colour": "#0aFf10", "visible": false, "label": 9,
       "forces": {"gradient": {"weight": 3}}, "final_vertices": 1280, "reference": {"labels": "truth.nii", "value": 2}},
      {"name": "other", "sphere": {"centre_mm": [0, 0, 0], "radius_mm": 1}, "reference": {"labels": "truth.nii"}}],
    "points": [{"mesh": "other", "position_mm": [4, 5, 6]}], "steps": 400)"));
  EXPECT_EQ(scene.simulation.damping, 0.25f);
  EXPECT_EQ(scene.simulation.limit_timestep, 0);
  EXPECT_EQ(scene.simulation.refresh_interval, 5);
  EXPECT_EQ(scene.simulation.timestep, default_simulation_parameters().timestep);
  ASSERT_EQ(scene.meshes.size(), 2u);
  const MeshItem& brain = scene.meshes[0];
  EXPECT_EQ(brain.seed.centre_mm, Eigen::Vector3d(1, -2, 3.5));
  EXPECT_EQ(brain.seed.radius_mm, 40);
  EXPECT_EQ(brain.colour, (Colour{10, 255, 16}));
  EXPECT_FALSE(brain.visible);
  EXPECT_EQ(brain.label, 9);
  EXPECT_EQ(brain.final_vertices, 1280);
  EXPECT_EQ(brain.reference->labels, "truth.nii");
  EXPECT_EQ(brain.reference->value, 2);
  EXPECT_EQ(brain.parameters.weight(ForceId::Gradient), 3);
  EXPECT_EQ(scene.meshes[1].parameters.weight(ForceId::Gradient), 2);
  EXPECT_FALSE(scene.meshes[1].reference->value);
  const int object = find_parameter(find_force("gradient")->parameters, "object");
  for (const MeshItem& item : scene.meshes)
    EXPECT_EQ(item.parameters.values[static_cast<int>(ForceId::Gradient)][object], 2);
  EXPECT_EQ(scene.forces.weight(ForceId::Gradient), 2);
  ASSERT_EQ(scene.points.size(), 1u);
  EXPECT_EQ(scene.points[0].mesh, scene.meshes[1].id);
  EXPECT_EQ(scene.points[0].position_mm, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(scene.steps, 400);
}

TEST_F(SceneIo, EveryParameterIsReadAndMustBeInItsRange) {
  const auto check = [&](const std::string& before, const ParameterInfo& info, const std::string& after,
                         auto value_in) {
    const float value = info.kind == ParameterKind::Real ? (info.minimum + info.maximum) / 2 : info.maximum;
    const std::string quote = info.kind == ParameterKind::Choice ? "\"" : "";
    const std::string text =
        before + "\"" + info.name + "\": " + quote + parameter_to_text(info, value) + quote + after;
    EXPECT_EQ(value_in(read_text(scene_with(text))), value) << text;
    for (const std::string wrong : {"null", "[1]", "\"nonsense\"", "true"}) {
      EXPECT_NE(refusal(scene_with(before + "\"" + info.name + "\": " + wrong + after)).find(info.name),
                std::string::npos)
          << text << wrong;
    }
    if (info.kind == ParameterKind::Choice) return;
    const double width = std::max(1.0, static_cast<double>(info.maximum - info.minimum));
    for (const double wrong : {info.minimum - width / 8 - 1, info.maximum + width / 8 + 1}) {
      const std::string message = refusal(scene_with(before + "\"" + info.name + "\": " + exact_text(wrong) + after));
      EXPECT_NE(message.find("out of range"), std::string::npos) << text << wrong << message;
    }
  };
  for (std::size_t p = 0; p < simulation_table().size(); ++p) {
    check("\"simulation\": {", simulation_table()[p], "}",
          [p](const Scene& s) { return value_of(s.simulation, static_cast<int>(p)); });
  }
  for (const ForceInfo& force : force_list()) {
    for (std::size_t p = 0; p < force.parameters.size(); ++p) {
      check("\"forces\": {\"" + std::string(force.name) + "\": {", force.parameters[p], "}}",
            [&, p](const Scene& s) { return s.forces.values[static_cast<int>(force.id)][p]; });
    }
  }
}

TEST_F(SceneIo, ErrorsAreOneLineWithFileAndPosition) {
  const std::string sphere = R"("sphere": {"centre_mm": [1, 2, 3], "radius_mm": 4})";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "empty"},
      {" \n", "empty"},
      {"{", "line 1"},
      {"{\n \"simplexseg_scene\": 1,\n \"steps\": NaN}", "line 3, column 11"},
      {scene_with("\"steps\": Infinity"), "line 1"},
      {scene_with("\"steps\": 1e999"), "scene.json"},
      {scene_with("\"steps\": null"), "steps"},
      {scene_with("\"steps\": -1"), "steps"},
      {scene_with("\"steps\": 2147483648"), "1000000000"},
      {scene_with("\"steps\": 1.5"), "steps"},
      {scene_with("\"steps\": 1, \"steps\": 2"), "twice"},
      {scene_with("\"steps\": 1} x {"), "line 1"},
      {"[]", "object"},
      {"3", "object"},
      {"{}", "simplexseg_scene"},
      {"{\"simplexseg_scene\": 2}", "simplexseg_scene"},
      {scene_with("\"volumes\": \"a\""), "'volume'"},
      {scene_with("\"volume\": \"no_such_file.nii\""), "no_such_file.nii"},
      {scene_with("\"volume\": \"\""), "volume"},
      {scene_with("\"volume\": 3"), "volume"},
      {scene_with("\"simulation\": {\"dampin\": 1}"), "'damping'"},
      {scene_with("\"simulation\": 3"), "simulation"},
      {scene_with("\"forces\": {\"gradent\": {}}"), "'gradient'"},
      {scene_with("\"forces\": {\"gradient\": {\"wieght\": 1}}"), "'weight'"},
      {scene_with("\"forces\": {\"gradient\": {\"object\": \"brigt\"}}"), "'bright'"},
      {scene_with("\"forces\": {\"gradient\": {\"samples\": 2.5}}"), "whole"},
      {scene_with("\"meshes\": {}"), "meshes"},
      {scene_with("\"meshes\": [3]"), "meshes[0]"},
      {scene_with("\"meshes\": [{" + sphere + "}]"), "'name'"},
      {scene_with("\"meshes\": [{\"name\": \"\", " + sphere + "}]"), "meshes[0].name"},
      {scene_with("\"meshes\": [{\"name\": \"a\"}]"), "'sphere'"},
      {scene_with("\"meshes\": [{\"name\": \"a\", " + sphere + "}, {\"name\": \"a\", " + sphere + "}]"),
       "meshes[1].name"},
      {mesh_with("\"colour\": \"red\""), "meshes[0].colour"},
      {mesh_with("\"colour\": \"#12345\""), "meshes[0].colour"},
      {mesh_with("\"colour\": \"#12345g\""), "meshes[0].colour"},
      {mesh_with("\"color\": \"#123456\""), "'colour'"},
      {mesh_with("\"visible\": 1"), "meshes[0].visible"},
      {mesh_with("\"label\": 0"), "meshes[0].label"},
      {mesh_with("\"label\": 65536"), "meshes[0].label"},
      {mesh_with("\"final_vertices\": 0"), "meshes[0].final_vertices"},
      {mesh_with("\"forces\": {\"smoothing\": {\"weight\": \"1\"}}"), "meshes[0].forces.smoothing.weight"},
      {mesh_with("\"forces\": {\"smoothing\": {\"weigth\": 1}}"), "meshes[0].forces.smoothing"},
      {mesh_with("\"reference\": {}"), "'labels'"},
      {mesh_with("\"reference\": {\"labels\": \"a\", \"label\": 1}"), "meshes[0].reference"},
      {mesh_with("\"pose\": \"missing.ply\""), "missing.ply"},
      {mesh_with("\"state\": \"missing.state\""), "pose"},
      {scene_with(R"("meshes": [{"name": "a", "sphere": {"centre_mm": [1, 2], "radius_mm": 4}}])"), "centre_mm"},
      {scene_with(R"("meshes": [{"name": "a", "sphere": {"centre_mm": [1, 2, null], "radius_mm": 4}}])"),
       "centre_mm[2]"},
      {scene_with(R"("meshes": [{"name": "a", "sphere": {"centre_mm": [1, 2, -1e308], "radius_mm": 4}}])"),
       "centre_mm[2]"},
      {scene_with(R"("meshes": [{"name": "a", "sphere": {"centre_mm": [1, 2, 3], "radius_mm": 1e308}}])"), "radius_mm"},
      {scene_with(R"("meshes": [{"name": "a", "sphere": {"centre_mm": [1, 2, 3], "radius_mm": 0}}])"), "radius_mm"},
      {scene_with(R"("meshes": [{"name": "a", "sphere": {"centre_mm": [1, 2, 3], "radius_mm": -1}}])"), "radius_mm"},
      {scene_with(R"("meshes": [{"name": "a", "sphere": {"center_mm": [1, 2, 3], "radius_mm": 1}}])"), "'centre_mm'"},
      {scene_with(R"("points": [{"mesh": "a", "position_mm": [1, 2, 3]}])"), "points[0].mesh"},
      {scene_with(R"("points": [{"position_mm": [1, 2, 3]}])"), "points[0]"},
  };
  for (const auto& [text, expected] : cases) {
    const std::string message = refusal(text);
    EXPECT_NE(message.find(expected), std::string::npos) << text << "\n" << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    if (expected == "no_such_file.nii" || expected == "missing.ply") continue;
    EXPECT_NE(message.find("scene.json"), std::string::npos) << message;
  }
}

TEST_F(SceneIo, RejectsMissingFilesFoldersAndOtherFormats) {
  EXPECT_THROW(read_scene(folder_ / "none.json"), Error);
  EXPECT_THROW(read_scene(folder_), Error);
  EXPECT_THROW(read_scene(write("bytes.json", std::string("\0\xff\x1f\x8b", 4))), Error);
  EXPECT_THROW(read_scene(write("deep.json", std::string(100000, '['))), Error);
  EXPECT_THROW(read_log(folder_ / "none.json"), Error);
  EXPECT_THROW(read_log(write("scene.json", scene_with("\"steps\": 1"))), Error);
}

TEST_F(SceneIo, RejectsAPoseWithoutVertices) {
  write("empty.ply",
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 0\nproperty list uchar int vertex_indices\nend_header\n");
  const std::string message = refusal(mesh_with("\"pose\": \"empty.ply\""));
  EXPECT_NE(message.find("empty.ply"), std::string::npos) << message;
}

TEST_F(SceneIo, FindsDataBesideTheSceneThenInTheDataFolders) {
  const char* const was = std::getenv("SIMPLEXSEG_DATA");
  const std::string before = was ? was : "";
  fs::create_directories(folder_ / "one");
  fs::create_directories(folder_ / "two");
  fs::create_directories(folder_ / "scenes");
  write("two/image.nii", "2");
  setenv("SIMPLEXSEG_DATA", ((folder_ / "one").string() + ":" + (folder_ / "two").string()).c_str(), 1);
  EXPECT_EQ(find_data("image.nii", folder_ / "scenes"), folder_ / "two/image.nii");
  write("one/image.nii", "1");
  EXPECT_EQ(find_data("image.nii", folder_ / "scenes"), folder_ / "one/image.nii");
  write("scenes/image.nii", "0");
  EXPECT_EQ(find_data("image.nii", folder_ / "scenes"), folder_ / "scenes/image.nii");
  EXPECT_EQ(find_data((folder_ / "two/image.nii").string(), folder_), folder_ / "two/image.nii");
  try {
    find_data("nowhere.nii", folder_ / "scenes");
    ADD_FAILURE() << "found";
  } catch (const Error& error) {
    for (const char* place : {"scenes/nowhere.nii", "one/nowhere.nii", "two/nowhere.nii", "mricron"})
      EXPECT_NE(std::string(error.what()).find(place), std::string::npos) << error.what();
  }
  was ? setenv("SIMPLEXSEG_DATA", before.c_str(), 1) : unsetenv("SIMPLEXSEG_DATA");
}

TEST_F(SceneIo, ASceneSavedElsewhereStillFindsItsVolume) {
  write("image.nii", "x");
  const SceneFile first = read_scene(write("scene.json", scene_with("\"volume\": \"image.nii\"")));
  EXPECT_EQ(first.volume, folder_ / "image.nii");
  fs::create_directories(folder_ / "elsewhere");
  write_scene(folder_ / "elsewhere/scene.json", first.scene);
  EXPECT_TRUE(fs::equivalent(read_scene(folder_ / "elsewhere/scene.json").volume, folder_ / "image.nii"));
  // A volume in the folder of the scene has a relative path, so both can be moved together.
  write_scene(folder_ / "saved.json", first.scene);
  fs::rename(folder_ / "saved.json", folder_ / "elsewhere/saved.json");
  fs::rename(folder_ / "image.nii", folder_ / "elsewhere/image.nii");
  EXPECT_TRUE(fs::equivalent(read_scene(folder_ / "elsewhere/saved.json").volume, folder_ / "elsewhere/image.nii"));
}

TEST_F(SceneIo, SetByPathChangesOnlyTheNamedParameter) {
  Scene scene = any_scene();
  scene.meshes[1].name = "b.c";
  const Scene before = scene;
  set_by_path(scene, "meshes.b.c.gradient.weight=1.25");
  EXPECT_EQ(scene.meshes[1].parameters.weight(ForceId::Gradient), 1.25f);
  EXPECT_TRUE(same_bits(scene.meshes[0].parameters, before.meshes[0].parameters));
  EXPECT_TRUE(same_bits(scene.forces, before.forces));
  set_by_path(scene, "forces.evidence.weight=0.5");
  for (const MeshItem& item : scene.meshes) EXPECT_EQ(item.parameters.weight(ForceId::Evidence), 0.5f);
  EXPECT_EQ(scene.forces.weight(ForceId::Evidence), 0.5f);
  set_by_path(scene, "forces.gradient.object=dark");
  EXPECT_EQ(scene.meshes[0].parameters.values[static_cast<int>(ForceId::Gradient)]
                                             [find_parameter(find_force("gradient")->parameters, "object")],
            2);
  set_by_path(scene, "simulation.damping=1e-1");
  EXPECT_EQ(scene.simulation.damping, 0.1f);
}

TEST_F(SceneIo, SetByPathSuggestsTheNearestName) {
  const std::vector<std::pair<std::string, std::string>> cases = {{"", "="},
                                                                  {"simulation.damping", "="},
                                                                  {"=1", "meshes.NAME"},
                                                                  {"simulation.dampin=1", "'damping'"},
                                                                  {"simulation.damping=", "number"},
                                                                  {"simulation.damping=x", "number"},
                                                                  {"simulation.damping=1x", "number"},
                                                                  {"simulation.damping=nan", "not a number"},
                                                                  {"simulation.damping=inf", "not a number"},
                                                                  {"simulation.damping=7", "range"},
                                                                  {"forces.gradient.wait=1", "'weight'"},
                                                                  {"forces.gradeint.weight=1", "'gradient'"},
                                                                  {"forces.gradient.object=dirk", "'dark'"},
                                                                  {"meshes.lift.gradient.weight=1", "'left'"},
                                                                  {"damping=1", "meshes.NAME"},
                                                                  {"simulation.refresh_interval=2.5", "whole"}};
  for (const auto& [assignment, expected] : cases) {
    Scene scene = any_scene();
    try {
      set_by_path(scene, assignment);
      ADD_FAILURE() << assignment << " was accepted";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
    }
  }
}

TEST_F(SceneIo, StrokesOfALassoOfEarlierVersionsAreRead) {
  // Saved before a lasso was one item: each of its strokes is a point, and all but the first continue its update.
  const Scene scene = read_text(scene_with(
      R"("meshes": [{"name": "ball", "sphere": {"centre_mm": [0, 0, 0], "radius_mm": 8}}], "points": [
         {"mesh": "ball", "position_mm": [14, 0, 0], "kind": "inside", "radius_mm": 1,
          "path_mm": [[-1.1, 5.1, 0], [-8, 12.5, 0], [-18.2, 13.3, 0], [-26.2, 6.8, 0], [-27.5, -3.5, 0], [-21.4, -11.8, 0]]},
         {"mesh": "ball", "position_mm": [10, 0, 0], "kind": "inside", "radius_mm": 2,
          "path_mm": [[-2.8, 6.8, 0], [-16.3, 7.6, 0], [-18, -5.8, 0], [-4.7, -8.4, 0]], "continues": true},
         {"mesh": "ball", "position_mm": [2, 0, 0], "kind": "inside", "radius_mm": 4,
          "path_mm": [[-1.8, 1.9, 0], [-2.3, -1.9, 0]], "continues": true},
         {"mesh": "ball", "position_mm": [18, 0, 0], "kind": "outside", "radius_mm": 1,
          "path_mm": [[-1.4, 6.6, 0], [-10.5, 16.2, 0], [-23.6, 17, 0], [-33.8, 8.6, 0]], "continues": true}])"));
  ASSERT_EQ(scene.points.size(), 4u);
  for (const UserPoint& point : scene.points) {
    EXPECT_TRUE(point.is_stroke());
    EXPECT_FALSE(point.is_lasso());
    EXPECT_EQ(point.continues, &point != &scene.points[0]);
  }
}

TEST_F(SceneIo, ALassoKeepsItsContour) {
  const std::string mesh = R"("meshes": [{"name": "a", "sphere": {"centre_mm": [0, 0, 0], "radius_mm": 8}}], )";
  const auto with_normal = [&](const std::string& normal) {
    return scene_with(
        mesh + R"("points": [{"mesh": "a", "position_mm": [5, 0, 1], "kind": "outside", "path_mm": [[0, 5, 0], )" +
        R"([-5, 5, 0]], "lasso_normal": )" + normal + "}]");
  };
  const Scene scene = read_text(with_normal("[0, 0, 1]"));
  ASSERT_EQ(scene.points.size(), 1u);
  EXPECT_TRUE(scene.points[0].is_lasso());
  EXPECT_EQ(scene.points[0].vertices_mm().back(), Eigen::Vector3d(0, 5, 1));
  EXPECT_NE(refusal(with_normal("[0, 0, 0]")).find("lasso_normal"), std::string::npos);
  EXPECT_NE(refusal(with_normal("[0, 0]")).find("lasso_normal"), std::string::npos);
}

}  // namespace
}  // namespace simplexseg
