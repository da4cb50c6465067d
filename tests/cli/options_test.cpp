// SPDX-License-Identifier: Apache-2.0
// Each option of each subcommand has its effect.
#include <zlib.h>

#include <memory>
#include <set>

#include "cli_fixture.h"
#include "core/parameters.h"
#include "core/session.h"
#include "gpu/backend.h"
#include "io/mesh_io.h"
#include "io/scene_io.h"
#include "io/volume_io.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

class Options : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    make_scene();
  }
  nlohmann::json report_of(Arguments arguments) const {
    arguments.insert(arguments.begin(), {"run", path("scene.json"), "--report", path("report.json")});
    succeed(arguments);
    return json_of("report.json");
  }
  Arguments run(Arguments arguments) const {
    arguments.insert(arguments.begin(), {"run", path("scene.json")});
    return arguments;
  }
  /// Session with the test's scene, on the CPU.
  std::unique_ptr<Session> open(const std::string& scene = "scene.json") const {
    SceneFile file = read_scene(path(scene));
    auto session = std::make_unique<Session>(make_cpu_engine(1));
    session->open(std::move(file.scene), read_volume(file.volume));
    return session;
  }
};

// ---- info ----

TEST_F(Options, Info) {
  const std::string text = succeed({"info", path("image.nii.gz")}).out;
  for (const char* word : {"24 x 24 x 24", "2, 2, 2 mm", "int16", "50 to 150", "NIfTI"}) EXPECT_NE(text.find(word), std::string::npos) << text;
  const nlohmann::json json = nlohmann::json::parse(succeed({"info", path("image.nii.gz"), "--json"}).out);
  EXPECT_EQ(json["size"], nlohmann::json({24, 24, 24}));
  EXPECT_EQ(json["spacing_mm"], nlohmann::json({2.0, 2.0, 2.0}));
  EXPECT_EQ(json["voxel_type"], "int16");
  EXPECT_EQ(json["range"], nlohmann::json({50.0, 150.0}));
  EXPECT_EQ(json["origin_mm"], nlohmann::json({-23.0, -23.0, -23.0}));
  EXPECT_EQ(json["direction"][1], nlohmann::json({0.0, 1.0, 0.0}));
  EXPECT_TRUE(json["warnings"].empty());
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
    for (const std::int16_t value : read_volume(path("image.nii")).voxels<std::int16_t>()) count += value > 100;
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

// ---- run ----

TEST_F(Options, RunSegmentsAndReports) {
  const nlohmann::json report = report_of({"--steps", "60"});
  EXPECT_EQ(report["steps"], 60);
  EXPECT_GT(report["wall_ms"], 0.0);
  EXPECT_GT(report["load_ms"], 0.0);
  EXPECT_NEAR(report["step_us"], report["wall_ms"].get<double>() * 1000 / 60, 1e-3);
  EXPECT_EQ(report["volume"]["path"], path("image.nii.gz"));
  EXPECT_EQ(report["volume"]["voxel_type"], "int16");
  EXPECT_EQ(report["parameters"]["simulation"]["final_vertices"], 320);
  EXPECT_TRUE(report["parameters"]["meshes"]["ball"]["gradient"].contains("weight"));
  ASSERT_EQ(report["meshes"].size(), 1u);
  const nlohmann::json& mesh = report["meshes"][0];
  EXPECT_EQ(mesh["name"], "ball");
  EXPECT_EQ(mesh["vertices"], 320);
  EXPECT_GT(mesh["volume_mm3"], 0.0);
  EXPECT_GT(mesh["area_mm2"], 0.0);
  EXPECT_GT(mesh["dice"], 0.8);   // the sphere it starts as has 0.41
  EXPECT_GE(mesh["hd_mm"], mesh["hd95_mm"]);
  EXPECT_GE(mesh["hd95_mm"], mesh["assd_mm"]);
  EXPECT_GE(mesh["assd_mm"], 0.0);
  const std::string table = succeed(run({})).out;
  for (const char* word : {"ball", "Dice", "HD95", "volume ml", "us a step"}) EXPECT_NE(table.find(word), std::string::npos) << table;
}

TEST_F(Options, AReportNamesNoAgreementWhereTheSceneNamesNoReference) {
  nlohmann::json scene = scene_json();
  scene["meshes"][0].erase("reference");
  write_scene("scene.json", scene);
  EXPECT_FALSE(report_of({})["meshes"][0].contains("dice"));
}

TEST_F(Options, Steps) {
  EXPECT_EQ(report_of({})["steps"], 30);
  EXPECT_EQ(report_of({"--steps", "7"})["steps"], 7);
  EXPECT_EQ(report_of({"--steps", "0"})["meshes"][0]["vertices"], 80);
}

TEST_F(Options, UntilRest) {
  const nlohmann::json report = report_of({"--until-rest", "--set", "simulation.rest_tolerance=0.05"});
  EXPECT_EQ(report["at_rest"], true);
  EXPECT_GT(report["steps"], 0);
  nlohmann::json scene = scene_json();
  scene.erase("steps");   // the same as asking for it
  write_scene("scene.json", scene);
  EXPECT_EQ(report_of({"--set", "simulation.rest_tolerance=0.05"})["steps"], report["steps"]);
}

TEST_F(Options, BackendAndThreads) {
  const nlohmann::json one = report_of({"--backend", "cpu", "--threads", "1", "--meshes", path("one")});
  EXPECT_EQ(one["backend"], "cpu");
  EXPECT_EQ(one["threads"], 1);
  const nlohmann::json three = report_of({"--backend", "cpu", "--threads", "3", "--meshes", path("three")});
  EXPECT_EQ(three["threads"], 3);
  EXPECT_NE(one["device"], three["device"]);
  EXPECT_EQ(text_of("one/ball.ply"), text_of("three/ball.ply"));   // threads change no bit
  if (why_no_cuda().empty()) {
    EXPECT_EQ(report_of({"--backend", "cuda"})["backend"], "cuda");
    EXPECT_EQ(report_of({"--backend", "auto"})["backend"], "cuda");
  } else {
    const Outcome refused = call(run({"--backend", "cuda"}));
    EXPECT_EQ(refused.status, 1);
    EXPECT_NE(refused.err.find(why_no_cuda()), std::string::npos) << refused.err;
    EXPECT_EQ(report_of({"--backend", "auto"})["backend"], "cpu");
  }
}

TEST_F(Options, Set) {
  const auto final_pose = [this](const Arguments& arguments) {
    succeed(run(arguments));
    return text_of("meshes/ball.ply");
  };
  const std::string plain = final_pose({"--meshes", path("meshes")});
  EXPECT_NE(plain, final_pose({"--meshes", path("meshes"), "--set", "simulation.damping=0.2"}));
  EXPECT_NE(plain, final_pose({"--meshes", path("meshes"), "--set", "forces.smoothing.weight=1.5"}));
  EXPECT_EQ(final_pose({"--meshes", path("meshes"), "--set", "forces.smoothing.weight=1.5"}),
            final_pose({"--meshes", path("meshes"), "--set", "meshes.ball.smoothing.weight=1.5"}));
  const nlohmann::json two = report_of({"--set", "simulation.damping=0.2", "--set", "simulation.refresh_interval=7"});
  EXPECT_EQ(two["parameters"]["simulation"]["damping"], 0.2);
  EXPECT_EQ(two["parameters"]["simulation"]["refresh_interval"], 7);
}

TEST_F(Options, Labels) {
  nlohmann::json scene = scene_json();
  scene["meshes"][0]["label"] = 5;
  write_scene("scene.json", scene);
  const nlohmann::json report = report_of({"--labels", path("labels.nii.gz")});
  const Volume labels = read_volume(path("labels.nii.gz"));
  EXPECT_EQ(labels.type(), VoxelType::UInt8);
  EXPECT_EQ(labels.range().max, 5);
  EXPECT_TRUE(labels.geometry().same_grid(read_volume(path("image.nii.gz")).geometry()));
  int count = 0;
  for (const std::uint8_t value : labels.voxels<std::uint8_t>()) count += value == 5;
  EXPECT_NEAR(count * 8.0, report["meshes"][0]["volume_mm3"], 0.05 * count * 8);
  // Compared as files, labels agree with the truth as the report says.
  succeed({"phantom", "label-image", path("labels.nii.gz"), path("x.nii"), "--labels", path("as_one.nii")});
  const nlohmann::json compared = nlohmann::json::parse(succeed({"compare", path("truth.nii.gz"), path("as_one.nii"), "--json"}).out);
  EXPECT_DOUBLE_EQ(compared["dice"], report["meshes"][0]["dice"]);
  EXPECT_DOUBLE_EQ(compared["hd95_mm"], report["meshes"][0]["hd95_mm"]);
}

TEST_F(Options, LabelsOfMeshesThatOverlap) {
  nlohmann::json scene = scene_json();
  nlohmann::json second = scene["meshes"][0];
  second["name"] = "again";
  second["label"] = 300;
  second["sphere"]["radius_mm"] = 14;
  scene["meshes"].push_back(second);
  write_scene("scene.json", scene);
  const Outcome outcome = succeed(run({"--steps", "0", "--labels", path("labels.nii")}));
  EXPECT_NE(outcome.err.find("two or more meshes"), std::string::npos);
  const Volume labels = read_volume(path("labels.nii"));
  EXPECT_EQ(labels.type(), VoxelType::UInt16);
  std::set<int> seen;
  for (const std::uint16_t value : labels.voxels<std::uint16_t>()) seen.insert(value);
  EXPECT_EQ(seen, (std::set<int>{0, 1, 300}));
  EXPECT_EQ(labels.sample({1, 0, 0}), 1);   // in both: the first has it
}

TEST_F(Options, Meshes) {
  nlohmann::json scene = scene_json();
  nlohmann::json second = scene["meshes"][0];
  scene["meshes"][0]["name"] = "../a/b";
  second["name"] = ".._a_b";
  scene["meshes"].push_back(second);
  write_scene("scene.json", scene);
  succeed(run({"--meshes", path("new/folder")}));
  int count = 0;
  for (const auto& entry : fs::directory_iterator(folder_ / "new/folder")) {
    EXPECT_EQ(read_mesh(entry.path()).vertex_count(), 320);
    ++count;
  }
  EXPECT_EQ(count, 2);
}

TEST_F(Options, Picture) {
  succeed(run({"--picture", path("slices.ppm")}));
  const std::string ppm = text_of("slices.ppm");
  int width = 0, height = 0, offset = 0;
  ASSERT_EQ(std::sscanf(ppm.c_str(), "P6\n%d %d\n255\n%n", &width, &height, &offset), 2);
  ASSERT_EQ(ppm.size(), static_cast<std::size_t>(offset + 3 * width * height));
  // Three panels: the centre of each is the bright object, its corner the background; the outline is coloured.
  int coloured[3] = {0, 0, 0};
  const auto pixel = [&](int x, int y, int c) { return static_cast<unsigned char>(ppm[offset + 3 * (y * width + x) + c]); };
  for (int x = 0; x < width; ++x)
    for (int y = 0; y < height; ++y) coloured[3 * x / width] += pixel(x, y, 0) == 230 && pixel(x, y, 2) == 60;
  for (int panel = 0; panel < 3; ++panel) {
    EXPECT_GT(coloured[panel], 200) << panel;
    EXPECT_GT(pixel((2 * panel + 1) * width / 6, height / 2, 0), pixel(panel * (width / 3) + 20, 5, 0) + 100) << panel;
  }
  // The PNG holds the same pixels.
  succeed(run({"--picture", path("slices.png")}));
  const std::string png = text_of("slices.png");
  ASSERT_EQ(png.substr(1, 3), "PNG");
  const auto u32 = [&png](std::size_t at) {
    return std::uint32_t(std::uint8_t(png[at])) << 24 | std::uint32_t(std::uint8_t(png[at + 1])) << 16 |
           std::uint32_t(std::uint8_t(png[at + 2])) << 8 | std::uint8_t(png[at + 3]);
  };
  EXPECT_EQ(u32(16), static_cast<std::uint32_t>(width));
  EXPECT_EQ(u32(20), static_cast<std::uint32_t>(height));
  std::string rows(static_cast<std::size_t>(height) * (1 + 3 * width), '\0');
  uLongf size = rows.size();
  ASSERT_EQ(uncompress(reinterpret_cast<Bytef*>(rows.data()), &size, reinterpret_cast<const Bytef*>(&png[41]), u32(33)), Z_OK);
  for (int y = 0; y < height; ++y) {
    ASSERT_EQ(rows.compare(y * (1 + 3 * width) + 1, 3 * width, ppm, offset + y * 3 * width, 3 * width), 0) << y;
  }
}

TEST_F(Options, Replay) {
  const std::unique_ptr<Session> session = open();
  session->advance_steps(11);
  const ItemId point = session->apply(AddAttractionPoint{session->scene().meshes[0].id, {17, 0, 0}});
  for (int move = 1; move <= 10; ++move) {
    session->advance_steps(1 + move % 3);
    session->apply(MoveAttractionPoint{point, {17 + 0.1 * move, 0.3 * move, 0}, move > 1});
  }
  session->advance_steps(5);
  session->apply(SetForceParameter{0, ForceId::Smoothing, 0, 0.7f});
  session->advance_steps(9);
  write_log(path("log.json"), session->log(), session->steps_since_last_command(), "scene.json");
  write_mesh(path("live.ply"), session->scene().meshes[0].mesh);
  for (const char* threads : {"1", "2"}) {
    const nlohmann::json report = report_of({"--backend", "cpu", "--threads", threads, "--replay", path("log.json"), "--meshes", path("replayed")});
    EXPECT_EQ(report["steps"], session->total_steps());
    EXPECT_EQ(text_of("replayed/ball.ply"), text_of("live.ply"));
  }
}

TEST_F(Options, ASavedSceneGoesOnFromTheSameBits) {
  const std::unique_ptr<Session> live = open();
  live->advance_steps(30);
  live->apply(RecordProfiles{0});
  live->advance_steps(30);   // a multiple of the refresh and rest intervals: both sides count on from the same place
  simplexseg::write_scene(path("saved.json"), live->scene());
  const std::unique_ptr<Session> reopened = open("saved.json");
  ASSERT_EQ(reopened->scene().meshes[0].mesh.positions, live->scene().meshes[0].mesh.positions);
  live->advance_steps(45);
  reopened->advance_steps(45);
  EXPECT_EQ(reopened->scene().meshes[0].mesh.positions, live->scene().meshes[0].mesh.positions);
  EXPECT_EQ(reopened->scene().meshes[0].previous, live->scene().meshes[0].previous);
}

// ---- plan ----

TEST_F(Options, PlanLeavesOutWhatHasNoWeight) {
  const auto plan = [this](Arguments arguments) {
    arguments.insert(arguments.begin(), {"plan", path("scene.json")});
    return succeed(arguments).out;
  };
  const nlohmann::json with = nlohmann::json::parse(plan({"--json", "--set", "forces.gradient.weight=1"}));
  const nlohmann::json without = nlohmann::json::parse(plan({"--json", "--set", "forces.gradient.weight=0", "--set", "forces.region.weight=0"}));
  ASSERT_FALSE(with["items"].empty());
  EXPECT_NE(with["items"], without["items"]);
  EXPECT_GT(with["bytes_held"], without["bytes_held"]);
  EXPECT_NE(plan({}).find("held:"), std::string::npos);
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
