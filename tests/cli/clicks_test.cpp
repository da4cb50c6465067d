// SPDX-License-Identifier: Apache-2.0
// Robot user on a phantom: outputs, and the effect of each option.
#include "cli_fixture.h"

namespace simplexseg {
namespace {

class Clicks : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    succeed({"phantom", "two-spheres", path("image.nii.gz"), "--labels", path("truth.nii.gz"), "--size", "32",
             "--noise", "30"});
  }
  nlohmann::json clicks(Arguments arguments) const {
    arguments.insert(arguments.begin(), {"clicks", path("image.nii.gz"), path("truth.nii.gz"), "--max", "3", "--label",
                                         "1", "--json", path("clicks.json")});
    succeed(arguments);
    return json_of("clicks.json");
  }
  /// Removes the values that differ between runs.
  static nlohmann::json comparable(nlohmann::json json) {
    json.erase("threads");
    for (nlohmann::json& at : json["cases"])
      for (nlohmann::json& click : at["clicks"]) click.erase("seconds");
    return json;
  }
};

TEST_F(Clicks, WriteEveryClickOfEveryLabel) {
  const Outcome outcome = succeed({"clicks", path("image.nii.gz"), path("truth.nii.gz"), "--label", "1", "--label", "2",
                                   "--max", "3", "--json", path("a.json"), "--csv", path("a.csv")});
  const nlohmann::json json = json_of("a.json");
  ASSERT_EQ(json["cases"].size(), 2u);
  std::size_t lines = 1;
  for (const nlohmann::json& at : json["cases"]) {
    lines += at["clicks"].size();
    ASSERT_GE(at["clicks"].size(), 1u) << at;
    EXPECT_EQ(at["clicks"][0]["kind"], "inside");
    EXPECT_GT(at["clicks"].back()["dice"].get<double>(), 0.85);
    EXPECT_TRUE(at["clicks_to"]["0.80"].is_number());
    EXPECT_LT(at["clicks"].back()["hd95_mm"].get<double>(), 3);
    EXPECT_NEAR(at["clicks"].back()["volume_ratio"].get<double>(), 1, 0.15);
    EXPECT_LT(at["clicks"].back()["assd_mm"].get<double>(), 1.5);
    for (std::size_t c = 1; c < at["clicks"].size(); ++c) {
      EXPECT_GE(at["clicks"][c]["depth_mm"].get<double>(), 1) << "at least one voxel is wrong";
      EXPECT_GT(at["clicks"][c]["farthest_mm"].get<double>(), 0);
      EXPECT_LT(at["clicks"][c]["far_share"].get<double>(), 1);
    }
  }
  const std::string csv = text_of("a.csv");
  const nlohmann::json& definitions = json["metric_definitions"];
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), lines + definitions.size());
  for (const char* key : {"dice", "hd95_mm", "assd_mm", "field_dice", "dice_with_field", "expected_dice", "folded",
                          "depth_mm", "far_share", "farthest_mm", "volume_ratio"}) {
    ASSERT_TRUE(definitions.contains(key)) << key;
    EXPECT_NE(csv.find(std::string("# ") + key + ": " + definitions[key].get<std::string>() + "\n"), std::string::npos);
  }
  EXPECT_NE(outcome.out.find("Dice: 2 |A and B|"), std::string::npos);
  EXPECT_NE(outcome.out.find("ASSD mm"), std::string::npos);
}

TEST_F(Clicks, ReportTheAgreementOfMeshAndField) {
  for (const nlohmann::json& click : clicks({})["cases"][0]["clicks"]) {
    EXPECT_EQ(click["field_dice"], click["dice"]) << "the robot 'mark' has no mesh";
    EXPECT_EQ(click["dice_with_field"], 1.0);
  }
  for (const nlohmann::json& click : clicks({"--robot", "mesh"})["cases"][0]["clicks"]) {
    EXPECT_GT(click["field_dice"], 0.85);
    EXPECT_GT(click["dice_with_field"], 0.95);
    EXPECT_LT(click["dice_with_field"], 1.0) << "compares the mesh, not the field";
  }
  for (const nlohmann::json& click : clicks({"--robot", "none"})["cases"][0]["clicks"])
    EXPECT_TRUE(click["dice_with_field"].is_null()) << "there is no field";
}

TEST_F(Clicks, AreReproducibleOnAnyNumberOfThreads) {
  EXPECT_EQ(comparable(clicks({"--threads", "1"})), comparable(clicks({"--threads", "2"})));
}

TEST_F(Clicks, EveryOptionHasAnEffect) {
  const nlohmann::json plain = comparable(clicks({}));
  for (const Arguments& more : std::vector<Arguments>{{"--seed-scale", "0.5"},
                                                      {"--seed-offset", "0.3"},
                                                      {"--without", "classifier"},
                                                      {"--without", "geodesic"},
                                                      {"--without", "prior"},
                                                      {"--without", "random-walk"},
                                                      {"--without", "sharpness"}}) {
    const nlohmann::json changed = comparable(clicks(more));
    EXPECT_NE(changed["cases"], plain["cases"]) << more[0] << " " << more[1];
  }
  const nlohmann::json mesh = comparable(clicks({"--robot", "mesh"}));
  EXPECT_NE(comparable(clicks({"--robot", "mesh", "--without", "classifier"}))["cases"], mesh["cases"])
      << "--without applies to the field of a mesh, too";
}

TEST_F(Clicks, RejectUnusableOptions) {
  const Outcome part = call({"clicks", path("image.nii.gz"), path("truth.nii.gz"), "--without", "clasifier"});
  EXPECT_EQ(part.status, 2);
  EXPECT_NE(part.err.find("classifier"), std::string::npos) << part.err;
  EXPECT_EQ(call({"clicks", path("image.nii.gz"), path("truth.nii.gz"), "--label", "77"}).status, 2);
  succeed({"phantom", "sphere", path("other.nii.gz"), "--labels", path("other_truth.nii.gz"), "--size", "16"});
  EXPECT_EQ(call({"clicks", path("image.nii.gz"), path("other_truth.nii.gz")}).status, 2);
  EXPECT_EQ(call({"clicks", path("image.nii.gz"), path("truth.nii.gz"), "--robot", "dog"}).status, 2);
  // Options that the robot does not use.
  const Outcome set = call({"clicks", path("image.nii.gz"), path("truth.nii.gz"), "--label", "1", "--max", "0", "--set",
                            "forces.evidence.weight=1"});
  EXPECT_EQ(set.status, 2);
  EXPECT_NE(set.err.find("--set"), std::string::npos) << set.err;
  const Outcome without = call({"clicks", path("image.nii.gz"), path("truth.nii.gz"), "--label", "1", "--max", "0",
                                "--robot", "none", "--without", "memory"});
  EXPECT_EQ(without.status, 2);
  EXPECT_NE(without.err.find("--without"), std::string::npos) << without.err;
  EXPECT_EQ(std::count(without.err.begin(), without.err.end(), '\n'), 1) << without.err;
}

}  // namespace
}  // namespace simplexseg
