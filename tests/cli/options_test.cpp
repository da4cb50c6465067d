// SPDX-License-Identifier: Apache-2.0
// Effect of each option of the subcommands other than run.
#include <algorithm>

#include "cli_fixture.h"
#include "forces/parameters.h"
#include "io/volume/volume_io.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

class Options : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    make_scene();
  }
};

TEST_F(Options, Info) {
  const std::string text = succeed({"info", path("image.nii.gz")}).out;
  for (const char* word : {"24 x 24 x 24", "2, 2, 2 mm", "int16", "50 to 150", "NIfTI"})
    EXPECT_NE(text.find(word), std::string::npos) << text;
  const nlohmann::json json = nlohmann::json::parse(succeed({"info", path("image.nii.gz"), "--json"}).out);
  EXPECT_EQ(json["size"], nlohmann::json({24, 24, 24}));
  EXPECT_EQ(json["spacing_mm"], nlohmann::json({2.0, 2.0, 2.0}));
  EXPECT_EQ(json["voxel_type"], "int16");
  EXPECT_EQ(json["range"], nlohmann::json({50.0, 150.0}));
  EXPECT_EQ(json["origin_mm"], nlohmann::json({-23.0, -23.0, -23.0}));
  EXPECT_EQ(json["direction"][1], nlohmann::json({0.0, 1.0, 0.0}));
  EXPECT_TRUE(json["warnings"].empty());
}

TEST_F(Options, NumbersAreDecimalUnderEveryLocale) {  // tests/locale/run repeats this under other locales
  succeed({"phantom", "sphere", path("p.nii"), "--size", "010", "--spacing", "0.5", "--noise", "+1.5"});
  EXPECT_EQ(read_volume(path("p.nii")).geometry().size, (std::array<int, 3>{10, 10, 10}));  // not octal
  for (const char* spacing : {"0,5", "0.5.5", "1 5", "0.5mm"}) {
    const Outcome refused = call({"phantom", "sphere", path("q.nii"), "--spacing", spacing});
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.err.find(spacing), std::string::npos) << refused.err;
  }
  for (const bool own_process : {false, true}) {
    const Arguments arguments{"info", path("p.nii")};
    const Outcome info = own_process ? call_program(arguments) : call(arguments);
    EXPECT_NE(info.out.find("spacing     0.5, 0.5, 0.5 mm"), std::string::npos) << info.out;
    EXPECT_NE(info.out.find("2.0 kB"), std::string::npos) << info.out;
  }
}

// ---- phantom ----

TEST_F(Options, PhantomSettings) {
  const auto made = [this](Arguments arguments) {
    arguments.insert(arguments.begin(), {"phantom", "sphere", path("p.nii"), "--size", "16"});
    succeed(arguments);
    return read_volume(path("p.nii"));
  };
  const Volume plain = made({});
  EXPECT_EQ(plain.geometry().size, (std::array<int, 3>{16, 16, 16}));
  EXPECT_EQ(plain.range().max - plain.range().min, 100);
  EXPECT_EQ(made({"--spacing", "0.5"}).geometry().spacing_mm, Eigen::Vector3d::Constant(0.5));
  const Volume dark = made({"--contrast", "-30"});
  EXPECT_LT(dark.value(8, 8, 8), dark.value(0, 0, 0));
  EXPECT_EQ(dark.range().max - dark.range().min, 30);
  EXPECT_EQ(made({"--background", "7"}).range().min, 7);
  EXPECT_EQ(made({"--type", "float32"}).type(), VoxelType::Float32);
  const auto values = [](const Volume& volume) {
    const auto voxels = volume.voxels<std::int16_t>();
    return std::vector<std::int16_t>(voxels.begin(), voxels.end());
  };
  const auto noisy = values(made({"--noise", "10"}));
  EXPECT_NE(noisy, values(plain));
  EXPECT_EQ(noisy, values(made({"--noise", "10", "--seed", "1"})));
  EXPECT_NE(noisy, values(made({"--noise", "10", "--seed", "2"})));
  made({"--labels", path("pl.nii")});
  EXPECT_EQ(read_volume(path("pl.nii")).range().max, 1);
}

TEST_F(Options, PhantomLabelImage) {
  succeed({"phantom", "two-spheres", path("x.nii"), "--labels", path("two.nii"), "--size", "24"});
  const auto bright_voxels = [this](Arguments arguments) {
    arguments.insert(arguments.begin(), {"phantom", "label-image", path("two.nii"), path("image.nii")});
    succeed(arguments);
    int count = 0;
    const Volume image = read_volume(path("image.nii"));
    for (const std::int16_t value : image.voxels<std::int16_t>()) count += value > 100;
    return count;
  };
  const int both = bright_voxels({}), first = bright_voxels({"--label", "1"});
  EXPECT_GT(first, 0);
  EXPECT_NEAR(both, 2 * first, first / 20 + 1);
  EXPECT_NE(bright_voxels({"--noise", "60"}), both);
  bright_voxels({"--label", "2", "--labels", path("truth2.nii")});
  EXPECT_EQ(read_volume(path("truth2.nii")).range().max, 1);
}

// ---- compare ----

TEST_F(Options, Compare) {
  succeed({"phantom", "two-spheres", path("x.nii"), "--labels", path("two.nii"), "--size", "24", "--spacing", "2"});
  const auto compared = [this](Arguments arguments) {
    arguments.insert(arguments.begin(), "compare");
    arguments.push_back("--json");
    return nlohmann::json::parse(succeed(arguments).out);
  };
  const nlohmann::json same = compared({path("two.nii"), path("two.nii")});
  EXPECT_EQ(same["dice"], 1.0);
  EXPECT_EQ(same["hd_mm"], 0.0);
  EXPECT_GT(same["reference_mm3"], 0.0);
  const nlohmann::json differ = compared({path("two.nii"), path("truth.nii.gz")});
  EXPECT_GT(differ["hd_mm"], differ["assd_mm"]);
  EXPECT_LT(differ["dice"], 1.0);
  const nlohmann::json none = compared({path("two.nii"), path("truth.nii.gz"), "--label", "2"});
  EXPECT_EQ(none["dice"], 0.0);
  EXPECT_EQ(none["test_mm3"], 0.0);
  EXPECT_TRUE(none["hd_mm"].is_null());
  // Every output contains the definition of every number.
  for (const auto& [key, value] : differ.items())
    EXPECT_TRUE(key == "definitions" || differ["definitions"][key].is_string()) << key;
  EXPECT_EQ(same["surface_dice"], 1.0);
  EXPECT_EQ(same["tolerance_mm"], 1.0);
  EXPECT_LT(differ["surface_dice"], 1.0);
  EXPECT_GT(compared({path("two.nii"), path("truth.nii.gz"), "--tolerance", "1000"})["surface_dice"], 0.999);
  const std::string csv = succeed({"compare", path("two.nii"), path("two.nii"), "--csv"}).out;
  EXPECT_TRUE(csv.starts_with("metric,value,definition\ndice,1,\"")) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), static_cast<long>(same["definitions"].size()) + 1);
  const std::string text = succeed({"compare", path("two.nii"), path("two.nii")}).out;
  EXPECT_NE(text.find("Dice"), std::string::npos);
  EXPECT_NE(text.find("1.0000"), std::string::npos);
}

// ---- parameters ----

TEST_F(Options, ParametersShowEveryParameter) {
  const std::string text = succeed({"parameters"}).out;
  const nlohmann::json json = nlohmann::json::parse(succeed({"parameters", "--json"}).out);
  const auto check = [&text](const nlohmann::json& list, std::span<const ParameterInfo> table) {
    ASSERT_EQ(list.size(), table.size());
    for (std::size_t p = 0; p < table.size(); ++p) {
      EXPECT_EQ(list[p]["name"], table[p].name);
      EXPECT_EQ(list[p]["doc"], table[p].doc);
      EXPECT_NE(text.find(table[p].doc), std::string::npos);
      if (table[p].kind == ParameterKind::Choice) {
        EXPECT_TRUE(list[p]["default"].is_string());
      } else {
        EXPECT_EQ(list[p]["default"].get<float>(), table[p].default_value);
        EXPECT_EQ(list[p]["minimum"].get<float>(), table[p].minimum);
        EXPECT_EQ(list[p]["maximum"].get<float>(), table[p].maximum);
      }
    }
  };
  check(json["simulation"], simulation_table());
  ASSERT_EQ(json["forces"].size(), force_list().size());
  for (std::size_t f = 0; f < force_list().size(); ++f) {
    EXPECT_EQ(json["forces"][f]["name"], force_list()[f].name);
    check(json["forces"][f]["parameters"], force_list()[f].parameters);
  }
}

// ---- plan ----

TEST_F(Options, PlanSkipsForcesWithoutWeight) {
  const auto plan = [this](Arguments arguments) {
    arguments.insert(arguments.begin(), {"plan", path("scene.json")});
    return succeed(arguments).out;
  };
  const nlohmann::json with = nlohmann::json::parse(plan({"--json", "--set", "forces.gradient.weight=1"}));
  const nlohmann::json without =
      nlohmann::json::parse(plan({"--json", "--set", "forces.gradient.weight=0", "--set", "forces.evidence.weight=0"}));
  ASSERT_FALSE(with["items"].empty());
  EXPECT_NE(with["items"], without["items"]);
  EXPECT_GT(with["bytes_held"], without["bytes_held"]);
  EXPECT_NE(plan({}).find("engine:"), std::string::npos);
  EXPECT_GT(with["field_cells"], 0);
  EXPECT_GT(with["field_bytes_solving"], with["field_bytes_held"]);
  EXPECT_EQ(without["field_cells"], 0);
  EXPECT_GE(with["process_bytes"], static_cast<std::size_t>(without["process_bytes"]) +
                                       static_cast<std::size_t>(with["field_bytes_held"]) +
                                       static_cast<std::size_t>(with["field_bytes_solving"]));
  EXPECT_NE(plan({"--set", "forces.evidence.weight=0"}).find("fields: none"), std::string::npos);
}

TEST_F(Options, HelpAndVersion) {
  EXPECT_NE(succeed({"--version"}).out.find("simplexseg-cli 0."), std::string::npos);
  for (const char* sub : {"info", "run", "compare", "phantom", "plan", "parameters"}) {
    EXPECT_NE(succeed({"--help"}).out.find(sub), std::string::npos);
    EXPECT_NE(succeed({sub, "--help"}).out.find("Usage"), std::string::npos);
  }
}

}  // namespace
}  // namespace simplexseg
