// SPDX-License-Identifier: Apache-2.0
// Several scenes in one call: each has the result of a single run, and a failed scene does not stop the others.
#include <set>

#include "cli_fixture.h"

namespace simplexseg {
namespace {

class RunSeveral : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    make_scene();
    for (const char* name : kNames) {
      nlohmann::json scene = scene_json();
      scene["meshes"][0]["sphere"]["radius_mm"] = 7 + 0.5 * static_cast<double>(scenes_.size());
      scene["forces"] = {{"evidence", {{"source", scenes_.size() % 2 == 0 ? "field" : "intensities"}}}};
      scenes_.push_back(write_scene(std::string(name) + ".json", scene));
    }
  }
  Arguments run_all(const Arguments& more) const {
    Arguments arguments{"run"};
    arguments.insert(arguments.end(), scenes_.begin(), scenes_.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  static constexpr const char* kNames[] = {"one", "two", "three", "four"};
  Arguments scenes_;
};

TEST_F(RunSeveral, EachResultIsIdenticalToASingleRun) {
  for (const char* at_once : {"1", "3", "16"}) {
    const std::string folder = path(at_once);
    std::filesystem::create_directory(folder);
    const Outcome outcome = succeed(run_all({"--at-once", at_once, "--labels", folder + "/{name}.nii.gz", "--meshes",
                                             folder + "/{name}", "--report", folder + "/{name}-report.json"}));
    EXPECT_NE(outcome.out.find("[4/4]"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("4 done, 0 failed"), std::string::npos) << outcome.out;
  }
  std::set<std::string> meshes;
  for (const char* name : kNames) {
    const std::string scene = path(std::string(name) + ".json"), alone = std::string("alone-") + name;
    succeed({"run", scene, "--labels", path("alone-{name}.nii.gz"), "--meshes", path("alone-{name}")});
    meshes.insert(text_of(alone + "/ball.ply"));
    for (const std::string at_once : {"1/", "3/", "16/"}) {
      EXPECT_EQ(text_of(at_once + name + ".nii.gz"), text_of(alone + ".nii.gz")) << at_once << name;
      EXPECT_EQ(text_of(at_once + name + "/ball.ply"), text_of(alone + "/ball.ply")) << at_once << name;
      EXPECT_EQ(json_of(at_once + name + "-report.json")["scene"], scene);
    }
  }
  EXPECT_EQ(meshes.size(), 4u) << "the scenes differ";
}

TEST_F(RunSeveral, AFailedSceneIsReportedAndTheOthersRun) {
  write("image-cut.nii", "no image");
  nlohmann::json broken = scene_json();
  broken["volume"] = "image-cut.nii";
  write_scene("two.json", broken);
  const Outcome outcome = call(run_all({"--at-once", "2", "--labels", path("{name}.nii.gz")}));
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("two: "), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("image-cut.nii"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("1 of 4 scenes failed"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.out.find("3 done, 1 failed"), std::string::npos) << outcome.out;
  for (const char* name : {"one.nii.gz", "three.nii.gz", "four.nii.gz"}) EXPECT_TRUE(exists(name)) << name;
  EXPECT_FALSE(exists("two.nii.gz"));
}

TEST_F(RunSeveral, OutputsOfSeveralScenesWithOneNameAreRejected) {
  Outcome outcome = call(run_all({"--labels", path("all.nii.gz")}));
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("--labels: all 4 scenes would write"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("{name}"), std::string::npos) << outcome.err;
  std::filesystem::create_directory(path("other"));
  Arguments twice = run_all({"--report", path("{name}.txt")});
  twice.insert(twice.begin() + 1, write_scene("other/one.simplexseg.json", scene_json()));
  outcome = call(twice);
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("rename one"), std::string::npos) << outcome.err;
  outcome = call(run_all({"--replay", path("log.json")}));
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("--replay"), std::string::npos) << outcome.err;
  EXPECT_FALSE(exists("all.nii.gz"));
  EXPECT_FALSE(exists("one.txt"));
}

}  // namespace
}  // namespace simplexseg
