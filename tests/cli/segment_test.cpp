// SPDX-License-Identifier: Apache-2.0
// Scenes that segment builds from its options, and their runs.
#include <algorithm>
#include <fstream>

#include "cli_fixture.h"
#include "io/scene/load_input.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

class Segment : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    make_scene();
    nlohmann::json scene = scene_json();
    scene.erase("volume"), scene.erase("meshes");
    write_scene("template.json", scene);
  }
  Arguments segment(Arguments arguments) const {
    arguments.insert(arguments.begin(), {"segment", path("image.nii.gz")});
    return arguments;
  }
  nlohmann::json report_of(Arguments arguments) const {
    arguments.insert(arguments.end(), {"--report", path("report.json")});
    succeed(segment(arguments));
    return json_of("report.json");
  }
  void expect_rejected(Arguments arguments, const std::string& why) const {
    const Outcome outcome = call(segment(arguments));
    EXPECT_EQ(outcome.status, 2) << why;
    EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
};

TEST_F(Segment, ASeedWithATemplateEqualsTheRunOfTheScene) {
  succeed({"run", path("scene.json"), "--labels", path("run.nii"), "--meshes", path("run")});
  succeed(segment({path("segment.nii"), "--scene", path("template.json"), "--seed", "1,0,0", "--radius", "9", "--name",
                   "ball", "--meshes", path("segment"), "--save", path("saved.json")}));
  EXPECT_EQ(text_of("segment.nii"), text_of("run.nii"));
  EXPECT_EQ(text_of("segment/ball.ply"), text_of("run/ball.ply"));
  const LoadedInput saved = load_scene(path("saved.json"));
  EXPECT_EQ(saved.volume_path, path("image.nii.gz"));
  EXPECT_EQ(saved.scene.meshes.at(0).seed.radius_mm, 9);
}

TEST_F(Segment, TemplateMeshesAreUsedWithoutVolumePoseAndReference) {
  succeed({"run", path("scene.json"), "--labels", path("run.nii"), "--save", path("posed.json")});
  nlohmann::json posed = json_of("posed.json");
  EXPECT_TRUE(posed["meshes"][0].contains("pose"));
  posed["volume"] = "nowhere.nii";
  posed["meshes"][0]["reference"]["labels"] = "nowhere.nii";
  write_scene("posed.json", posed);
  const nlohmann::json report =
      report_of({"--scene", path("posed.json"), "--labels", path("segment.nii"), "--steps", "30"});
  EXPECT_EQ(text_of("segment.nii"), text_of("run.nii")) << "starts from the seed and ignores the pose";
  EXPECT_FALSE(report["meshes"][0].contains("dice"));
  EXPECT_TRUE(
      report_of({"--scene", path("posed.json"), "--reference", path("truth.nii.gz")})["meshes"][0].contains("dice"));
  succeed(segment({path("moved.nii"), "--scene", path("posed.json"), "--seed", "3,0,0", "--radius", "5"}));
  EXPECT_NE(text_of("moved.nii"), text_of("run.nii"));
}

TEST_F(Segment, EachSeedCreatesAMesh) {
  const nlohmann::json report = report_of({"--seed",
                                           "-8,0,0",
                                           "--seed",
                                           "8,0,0",
                                           "--radius",
                                           "3",
                                           "--radius",
                                           "4",
                                           "--name",
                                           "left",
                                           "--name",
                                           "right",
                                           "--reference",
                                           path("truth.nii.gz"),
                                           "--reference-label",
                                           "1",
                                           "--steps",
                                           "0",
                                           "--labels",
                                           path("two.nii")});
  ASSERT_EQ(report["meshes"].size(), 2u);
  EXPECT_EQ(report["meshes"][1]["name"], "right");
  EXPECT_LT(report["meshes"][0]["volume_mm3"], report["meshes"][1]["volume_mm3"]);
  EXPECT_TRUE(report["meshes"][1].contains("dice"));
  EXPECT_EQ(read_volume(path("two.nii")).range().max, 2);
}

TEST_F(Segment, PointsBelongToTheNamedMesh) {
  succeed(segment({"--seed", "0,0,0", "--inside", "1,2,3", "--outside", "-9,-9,-9", "--boundary=0,0,8", "--steps", "0",
                   "--save", path("points.json")}));
  const Scene scene = load_scene(path("points.json")).scene;
  ASSERT_EQ(scene.points.size(), 3u);
  EXPECT_EQ(scene.points[0].kind, MarkKind::Inside);
  EXPECT_EQ(scene.points[0].position_mm, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scene.points[1].kind, MarkKind::Outside);
  EXPECT_EQ(scene.points[2].kind, MarkKind::Boundary);
  EXPECT_EQ(scene.meshes.at(0).seed.radius_mm, 10) << "without --radius";
  succeed(segment({"--seed", "-8,0,0", "--seed", "8,0,0", "--inside", "mesh 2=8,1,0", "--steps", "0", "--save",
                   path("points.json")}));
  EXPECT_EQ(load_scene(path("points.json")).scene.points.at(0).mesh, 2u);
  expect_rejected({"--seed", "-8,0,0", "--seed", "8,0,0", "--inside", "8,1,0"}, "has 2 meshes");
  expect_rejected({"--seed", "0,0,0", "--inside", "heart=8,1,0"}, "no mesh has this name");
}

TEST_F(Segment, MeshesStartFromLabels) {
  succeed({"phantom", "two-spheres", path("x.nii"), "--labels", path("two.nii"), "--size", "24", "--spacing", "2"});
  const nlohmann::json report =
      report_of({"--labels-start", path("two.nii"), "--steps", "0", "--labels", path("again.nii")});
  ASSERT_EQ(report["meshes"].size(), 2u);
  EXPECT_EQ(report["meshes"][0]["name"], "label 1");
  const nlohmann::json same =
      nlohmann::json::parse(succeed({"compare", path("two.nii"), path("again.nii"), "--label", "2", "--json"}).out);
  EXPECT_GT(same["dice"], 0.95);
  expect_rejected({"--labels-start", path("two.nii"), "--seed", "0,0,0"}, "--seed");
}

TEST_F(Segment, InvalidOptionsAreRejectedInOneLine) {
  expect_rejected({}, "the position of the object is missing");
  expect_rejected({"--radius", "4"}, "no seed");
  expect_rejected({"--seed", "1,2"}, "three numbers");
  expect_rejected({"--seed", "1,2,x"}, "three numbers");
  expect_rejected({"--seed", "1,2,3,4"}, "three numbers");
  expect_rejected({"--seed", "1,2,nan"}, "three numbers");
  expect_rejected({"--seed", "0,0,900"}, "outside");
  expect_rejected({"--seed", "0,0,0", "--radius", "-1"}, "radius");
  expect_rejected({"--seed", "0,0,0", "--radius", "1", "--radius", "2"}, "2 radii for 1 seed");
  expect_rejected({"--seed", "0,0,0", "--seed", "1,0,0", "--scene", path("scene.json")}, "2 seeds for 1 mesh");
  expect_rejected({"--seed", "0,0,0", "--name", "a", "--name", "b"}, "2 names for 1 mesh");
  expect_rejected({"--seed", "0,0,0", "--seed", "1,0,0", "--name", "a", "--name", "a"}, "two meshes");
  expect_rejected({"--seed", "0,0,0", "--reference-label", "1"}, "--reference");
  expect_rejected({"--seed", "0,0,0", "--labels", path("image.nii.gz")}, "it is an input of this command");
  expect_rejected({"--seed", "0,0,0", "--scene", path("none.json")}, "none.json");
}

TEST_F(Segment, PlanEstimatesMemoryAndTime) {
  const auto plan = [this](Arguments more) {
    more.insert(more.end(), {"--seed", "0,0,0", "--plan"});
    return nlohmann::json::parse(succeed(segment(more)).out);
  };
  const nlohmann::json few = plan({"--steps", "100"}), many = plan({"--steps", "1000"}), rest = plan({});
  EXPECT_EQ(few["run_steps"], 100);
  EXPECT_GT(rest["run_steps"], 0);
  EXPECT_LT(few["run_seconds"], many["run_seconds"]);
  EXPECT_GT(few["process_bytes"], few["bytes_held"]);
  EXPECT_GT(plan({"--set", "simulation.final_vertices=81920"})["process_bytes"], few["process_bytes"]);
  const nlohmann::json of_scene = nlohmann::json::parse(succeed({"plan", path("scene.json"), "--json"}).out);
  EXPECT_EQ(of_scene["run_steps"], 30);
  EXPECT_NE(succeed({"plan", path("scene.json")}).out.find("for 30 steps"), std::string::npos);
}

TEST_F(Segment, OptionsWithoutASubcommandAreThoseOfSegment) {
  succeed(segment({path("named.nii"), "--seed", "0,0,0", "--radius", "5", "--steps", "5"}));
  succeed({"--seed", "0,0,0", "--radius", "5", "--steps", "5", path("image.nii.gz"), path("unnamed.nii")});
  EXPECT_EQ(text_of("unnamed.nii"), text_of("named.nii"));
  const Outcome unknown = call({"--no-such-option"});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_NE(unknown.err.find("subcommand"), std::string::npos) << unknown.err;
  for (const Arguments& how : {Arguments{"--xml"}, Arguments{"segment", "--xml"}})
    EXPECT_TRUE(succeed(how).out.starts_with("<?xml")) << "called by 3D Slicer";
}

TEST_F(Segment, ALabelPresetGivesLabelsColoursAndCodesByName) {
  succeed(segment({path("a.seg.nrrd"), "--seed", "1,0,0", "--radius", "9", "--name", "spleen", "--label-preset",
                   "abdomen", "--steps", "1", "--save", path("saved.json")}));
  const nlohmann::json saved = json_of("saved.json");
  EXPECT_EQ(saved["meshes"][0]["label"], 1);
  EXPECT_EQ(saved["meshes"][0]["code"]["type"]["code"], "78961009");
  EXPECT_EQ(saved["labels"]["preset"], "abdomen");
  EXPECT_EQ(saved["labels"]["by_name"]["spleen"], 1);
  EXPECT_EQ(saved["labels"]["by_name"]["Liver"], 6);
  EXPECT_NE(text_of("a.seg.nrrd").find("~SCT^78961009^Spleen~"), std::string::npos);
  write_scene("own.json", {{"simplexseg_labels", 1},
                           {"title", "Own"},
                           {"labels", {{{"name", "Ball"}, {"number", 77}, {"colour", "#010203"}}}}});
  succeed(segment({path("b.seg.nrrd"), "--seed", "1,0,0", "--radius", "9", "--name", "Ball", "--label-preset",
                   path("own.json"), "--steps", "1", "--save", path("saved.json")}));
  EXPECT_EQ(json_of("saved.json")["meshes"][0]["label"], 77);
  EXPECT_EQ(json_of("saved.json")["meshes"][0]["colour"], "#010203");
  EXPECT_EQ(json_of("saved.json")["labels"]["preset"], "own.json") << "relative to the scene";
  EXPECT_EQ(load_scene(path("saved.json")).scene.labels.preset, path("own.json"));
  expect_rejected({path("c.nii"), "--seed", "1,0,0", "--label-preset", "abdomn"}, "abdomen");
  expect_rejected({path("c.nii"), "--seed", "1,0,0", "--label-preset", path("none.json")}, "none.json");
}

TEST_F(Segment, PresetsAreListed) {
  const Outcome all = call({"labels"});
  EXPECT_EQ(all.status, 0);
  for (const char* name : {"abdomen", "spine", "brain", "heart", "head-neck"})
    EXPECT_NE(all.out.find(name), std::string::npos) << name;
  EXPECT_NE(call({"labels", "heart"}).out.find("SCT 87878005 Left Ventricle"), std::string::npos);
  const Outcome file = call({"labels", "spine", "--json"});
  std::ofstream(path("spine.json")) << file.out;
  EXPECT_EQ(call({"labels", path("spine.json"), "--json"}).out, file.out);
  const Outcome unknown = call({"labels", "hart"});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_NE(unknown.err.find("'heart'"), std::string::npos) << unknown.err;
}

}  // namespace
}  // namespace simplexseg
