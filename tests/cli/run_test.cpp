// SPDX-License-Identifier: Apache-2.0
// Effect of each option of run, and reproducibility of a run.
#include <zlib.h>

#include <chrono>
#include <memory>
#include <set>

#include "cli_fixture.h"
#include "gpu/backend.h"
#include "io/mesh/mesh_io.h"
#include "io/scene/load_input.h"
#include "io/scene/scene_io.h"
#include "io/volume/volume_io.h"
#include "session/session.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

/// Sum of the voxels of a volume times the volume of a voxel, mm3.
double content_mm3(const Volume& volume) {
  double sum = 0;
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    for (const T value : volume.voxels<T>()) sum += static_cast<double>(value);
  });
  return sum * volume.geometry().spacing_mm.prod();
}

class Run : public Cli {
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
  /// Opens the scene of the test in a session on the CPU.
  std::unique_ptr<Session> open(const std::string& scene = "scene.json") const {
    SceneFile file = read_scene(path(scene));
    auto session = std::make_unique<Session>(make_cpu_engine(1));
    session->open(std::move(file.scene), read_volume(file.volume));
    return session;
  }
};

TEST_F(Run, RunSegmentsAndReports) {
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
  EXPECT_GT(mesh["dice"], 0.65);  // the initial sphere has 0.41; meshes with few vertices shrink
  EXPECT_GE(mesh["hd_mm"], mesh["hd95_mm"]);
  EXPECT_GE(mesh["hd95_mm"], mesh["assd_mm"]);
  EXPECT_GE(mesh["assd_mm"], 0.0);
  const std::string table = succeed(run({})).out;
  for (const char* word : {"ball", "Dice", "HD95", "volume ml", "us per step"})
    EXPECT_NE(table.find(word), std::string::npos) << table;
}

TEST_F(Run, AReportWithoutReferenceHasNoAgreement) {
  nlohmann::json scene = scene_json();
  scene["meshes"][0].erase("reference");
  write_scene("scene.json", scene);
  const nlohmann::json report = report_of({});
  EXPECT_FALSE(report["meshes"][0].contains("dice"));
  EXPECT_FALSE(report["meshes"][0]["trace"].contains("error_mean_mm"));
  EXPECT_EQ(report["meshes"][0]["trace"]["residual_mm"].size(), 4u);
}

TEST_F(Run, TheReportTracesTheRun) {
  const nlohmann::json report = report_of({"--steps", "65"});
  const nlohmann::json trace = report["meshes"][0]["trace"];
  EXPECT_EQ(trace["steps"], (std::vector<int>{0, 10, 20, 30, 40, 50, 60, 65}));
  for (const char* name :
       {"seconds", "vertices", "residual_mm", "mean_move_mm", "error_mean_mm", "error_p95_mm", "error_max_mm"})
    ASSERT_EQ(trace[name].size(), 8u) << name;
  EXPECT_EQ(trace["vertices"].front(), 80);
  EXPECT_EQ(trace["vertices"].back(), 320);
  EXPECT_EQ(trace["seconds"].front(), 0);
  for (int s = 1; s < 8; ++s) EXPECT_GT(trace["seconds"][s], trace["seconds"][s - 1]);
  EXPECT_DOUBLE_EQ(1000 * trace["seconds"].back().get<double>(), report["wall_ms"]);
  EXPECT_LT(trace["error_mean_mm"].back().get<double>(), 0.5 * trace["error_mean_mm"].front().get<double>());
  EXPECT_LE(trace["error_p95_mm"].back(), trace["error_max_mm"].back());
  // A report does not change the result of the run.
  succeed(run({"--steps", "65", "--meshes", path("plain")}));
  report_of({"--steps", "65", "--meshes", path("traced")});
  EXPECT_EQ(text_of("plain/ball.ply"), text_of("traced/ball.ply"));
  // The size of the trace is bounded.
  EXPECT_LE(
      report_of({"--steps", "5000", "--set", "simulation.final_vertices=80"})["meshes"][0]["trace"]["steps"].size(),
      201u);
}

TEST_F(Run, Steps) {
  EXPECT_EQ(report_of({})["steps"], 30);
  EXPECT_EQ(report_of({"--steps", "7"})["steps"], 7);
  EXPECT_EQ(report_of({"--steps", "0"})["meshes"][0]["vertices"], 80);
}

TEST_F(Run, SaveWritesTheSceneAfterTheRun) {
  succeed(run({"--steps", "20", "--save", path("later.json"), "--meshes", path("now")}));
  for (const char* folder : {"opened", "again"})
    succeed(
        {"run", path("later.json"), "--steps", folder == std::string("opened") ? "0" : "25", "--meshes", path(folder)});
  EXPECT_EQ(text_of("opened/ball.ply"), text_of("now/ball.ply"));
  EXPECT_NE(text_of("again/ball.ply"), text_of("now/ball.ply"));
  succeed({"run", path("later.json"), "--steps", "25", "--threads", "2", "--meshes", path("once more")});
  EXPECT_EQ(text_of("again/ball.ply"), text_of("once more/ball.ply")) << "continued runs are reproducible";
  EXPECT_NE(call(run({"--save", path("scene.json")})).err.find("it is an input of this command"), std::string::npos);
  EXPECT_NE(call(run({"--save", path("later.txt")})).err.find("ends in .json"), std::string::npos);
}

TEST_F(Run, UntilRest) {
  const nlohmann::json report = report_of({"--until-rest", "--set", "simulation.rest_tolerance=0.05"});
  EXPECT_EQ(report["at_rest"], true);
  EXPECT_GT(report["steps"], 0);
  nlohmann::json scene = scene_json();
  scene.erase("steps");  // equivalent to --until-rest
  write_scene("scene.json", scene);
  EXPECT_EQ(report_of({"--set", "simulation.rest_tolerance=0.05"})["steps"], report["steps"]);
}

TEST_F(Run, BackendAndThreads) {
  const nlohmann::json one = report_of({"--backend", "cpu", "--threads", "1", "--meshes", path("one")});
  EXPECT_EQ(one["backend"], "cpu");
  EXPECT_EQ(one["threads"], 1);
  const nlohmann::json three = report_of({"--backend", "cpu", "--threads", "3", "--meshes", path("three")});
  EXPECT_EQ(three["threads"], 3);
  EXPECT_NE(one["device"], three["device"]);
  EXPECT_EQ(text_of("one/ball.ply"), text_of("three/ball.ply"));  // the number of threads does not change the result
  if (cuda_unavailable_reason().empty()) {
    EXPECT_EQ(report_of({"--backend", "cuda"})["backend"], "cuda");
    EXPECT_EQ(report_of({"--backend", "auto"})["backend"], "cuda");
  } else {
    const Outcome failed = call(run({"--backend", "cuda"}));
    EXPECT_EQ(failed.status, 1);
    EXPECT_NE(failed.err.find(cuda_unavailable_reason()), std::string::npos) << failed.err;
    EXPECT_EQ(report_of({"--backend", "auto"})["backend"], "cpu");
  }
}

TEST_F(Run, Set) {
  const auto final_pose = [this](const Arguments& arguments) {
    succeed(run(arguments));
    return text_of("meshes/ball.ply");
  };
  const std::string plain = final_pose({"--meshes", path("meshes")});
  const std::string verlet = final_pose({"--meshes", path("meshes"), "--set", "simulation.solver=verlet"});
  EXPECT_NE(plain, verlet);
  EXPECT_NE(verlet, final_pose({"--meshes", path("meshes"), "--set", "simulation.solver=verlet", "--set",
                                "simulation.damping=0.2"}));
  EXPECT_NE(plain, final_pose({"--meshes", path("meshes"), "--set", "forces.smoothing.weight=1.5"}));
  EXPECT_EQ(final_pose({"--meshes", path("meshes"), "--set", "forces.smoothing.weight=1.5"}),
            final_pose({"--meshes", path("meshes"), "--set", "meshes.ball.smoothing.weight=1.5"}));
  const nlohmann::json two = report_of({"--set", "simulation.damping=0.2", "--set", "simulation.refresh_interval=7"});
  EXPECT_EQ(two["parameters"]["simulation"]["damping"], 0.2);
  EXPECT_EQ(two["parameters"]["simulation"]["refresh_interval"], 7);
}

TEST_F(Run, Labels) {
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
  // `compare` computes the same agreement from the files as the report.
  succeed({"phantom", "label-image", path("labels.nii.gz"), path("x.nii"), "--labels", path("as_one.nii")});
  const nlohmann::json compared =
      nlohmann::json::parse(succeed({"compare", path("truth.nii.gz"), path("as_one.nii"), "--json"}).out);
  EXPECT_DOUBLE_EQ(compared["dice"], report["meshes"][0]["dice"]);
  EXPECT_DOUBLE_EQ(compared["hd95_mm"], report["meshes"][0]["hd95_mm"]);
}

TEST_F(Run, LabelsOfMeshesThatOverlap) {
  nlohmann::json scene = scene_json();
  nlohmann::json second = scene["meshes"][0];
  second["name"] = "again";
  second["label"] = 300;
  second["sphere"]["radius_mm"] = 14;
  scene["meshes"].push_back(second);
  write_scene("scene.json", scene);
  const Outcome outcome = succeed(run({"--steps", "0", "--labels", path("labels.nii")}));
  EXPECT_NE(outcome.err.find("two or more segmentations"), std::string::npos);
  const Volume labels = read_volume(path("labels.nii"));
  EXPECT_EQ(labels.type(), VoxelType::UInt16);
  std::set<int> seen;
  for (const std::uint16_t value : labels.voxels<std::uint16_t>()) seen.insert(value);
  EXPECT_EQ(seen, (std::set<int>{0, 1, 300}));
  EXPECT_EQ(labels.sample({1, 0, 0}), 1);  // in both meshes: assigned to the first
}

TEST_F(Run, Meshes) {
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

TEST_F(Run, Picture) {
  succeed(run({"--picture", path("slices.ppm")}));
  const std::string ppm = text_of("slices.ppm");
  int width = 0, height = 0, offset = 0;
  ASSERT_EQ(std::sscanf(ppm.c_str(), "P6\n%d %d\n255\n%n", &width, &height, &offset), 2);
  ASSERT_EQ(ppm.size(), static_cast<std::size_t>(offset + 3 * width * height));
  // Three panels: bright object in the centre, background in the corner, coloured outline.
  int coloured[3] = {0, 0, 0};
  const auto pixel = [&](int x, int y, int c) {
    return static_cast<unsigned char>(ppm[offset + 3 * (y * width + x) + c]);
  };
  for (int x = 0; x < width; ++x)
    for (int y = 0; y < height; ++y) coloured[3 * x / width] += pixel(x, y, 0) == 230 && pixel(x, y, 2) == 60;
  for (int panel = 0; panel < 3; ++panel) {
    EXPECT_GT(coloured[panel], 200) << panel;
    EXPECT_GT(pixel((2 * panel + 1) * width / 6, height / 2, 0), pixel(panel * (width / 3) + 20, 5, 0) + 100) << panel;
  }
  // The PNG has the same pixels.
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
  ASSERT_EQ(uncompress(reinterpret_cast<Bytef*>(rows.data()), &size, reinterpret_cast<const Bytef*>(&png[41]), u32(33)),
            Z_OK);
  for (int y = 0; y < height; ++y) {
    ASSERT_EQ(rows.compare(y * (1 + 3 * width) + 1, 3 * width, ppm, offset + y * 3 * width, 3 * width), 0) << y;
  }
}

TEST_F(Run, Replay) {
  const std::unique_ptr<Session> session = open();
  session->advance_steps(11);
  const ItemId point = session->apply(AddPoint{session->scene().meshes[0].id, {17, 0, 0}});
  for (int move = 1; move <= 10; ++move) {
    session->advance_steps(1 + move % 3);
    session->apply(MovePoint{point, {17 + 0.1 * move, 0.3 * move, 0}, move > 1});
  }
  session->advance_steps(5);
  session->apply(SetForceParameter{0, ForceId::Smoothing, 0, 0.7f});
  session->advance_steps(9);
  write_log(path("log.json"), session->log(), session->steps_since_last_command(), "scene.json");
  write_mesh(path("live.ply"), session->scene().meshes[0].mesh);
  for (const char* threads : {"1", "2"}) {
    const nlohmann::json report = report_of(
        {"--backend", "cpu", "--threads", threads, "--replay", path("log.json"), "--meshes", path("replayed")});
    EXPECT_EQ(report["steps"], session->total_steps());
    EXPECT_EQ(text_of("replayed/ball.ply"), text_of("live.ply"));
  }
}

TEST_F(Run, ALogOfALiveRunReplaysToTheSameBits) {
  const std::unique_ptr<Session> session = open();
  const auto hung = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  const auto run_until_settled = [&] {
    while (!session->advance(0.002).at_rest && std::chrono::steady_clock::now() < hung) continue;
  };
  run_until_settled();
  session->apply(AddPoint{session->scene().meshes[0].id, {0, 10, 0}, MarkKind::Outside, 3});
  session->apply(ResetPose{0});  // so that steps are made until the field is solved
  run_until_settled();
  const auto steps_before = [&]<class C>(std::type_identity<C>) {
    int most = -1;
    for (const LogEntry& entry : session->log())
      if (std::holds_alternative<C>(entry.command)) most = std::max(most, entry.steps);
    return most;
  };
  ASSERT_GT(steps_before(std::type_identity<CommitFieldUpdate>()), 0) << "the field was solved in the background";
  ASSERT_GE(steps_before(std::type_identity<CommitFieldComparison>()), 0);
  write_log(path("log.json"), session->log(), session->steps_since_last_command(), "scene.json");
  write_mesh(path("live.ply"), session->scene().meshes[0].mesh);
  report_of({"--backend", "cpu", "--replay", path("log.json"), "--meshes", path("replayed")});
  EXPECT_EQ(text_of("replayed/ball.ply"), text_of("live.ply"));
}

TEST_F(Run, TheUndoHistoryIsSavedWithAScene) {
  const std::unique_ptr<Session> session = open();
  const ItemId point = session->apply(AddPoint{session->scene().meshes[0].id, {17, 0, 0}});
  session->advance_steps(4);
  session->apply(MovePoint{point, {18, 0, 0}});
  session->advance_steps(3);
  write_log(path("log.json"), session->log(), session->steps_since_last_command(), "scene.json");
  const auto history_of = [&](const char* scene) {
    const LoadedInput input = load_input(path(scene));
    EXPECT_TRUE(input.warnings.empty());
    return input.history.undo_names();
  };
  succeed(run({"--replay", path("log.json"), "--save", path("replayed.json")}));
  ASSERT_EQ(history_of("replayed.json"), session->history().undo_names());
  // A continued run keeps the history, and a log may undo actions from before its start.
  succeed({"run", path("replayed.json"), "--steps", "6", "--save", path("later.json")});
  EXPECT_EQ(history_of("later.json"), session->history().undo_names());
  write("undo.json",
        R"({"simplexseg_log": 1, "entries": [{"after_steps": 0, "command": "undo"}], "trailing_steps": 0})");
  succeed({"run", path("replayed.json"), "--replay", path("undo.json"), "--meshes", path("undone")});
  session->apply(Undo{});
  write_mesh(path("undone.ply"), session->scene().meshes[0].mesh);
  EXPECT_EQ(text_of("undone/ball.ply"), text_of("undone.ply"));
  // Saving a scene without history deletes an old history file.
  EXPECT_TRUE(exists("later.history"));
  succeed(run({"--steps", "5", "--save", path("later.json")}));
  EXPECT_FALSE(exists("later.history"));
  // A damaged history is only a warning.
  write("replayed.history", "damaged");
  const Outcome outcome = succeed({"run", path("replayed.json"), "--steps", "2", "--save", path("third.json")});
  EXPECT_NE(outcome.err.find("warning: cannot restore the undo history"), std::string::npos) << outcome.err;
  EXPECT_FALSE(exists("third.history"));
}

TEST_F(Run, ASavedSceneContinuesIdentically) {
  // Uses evidence from intensities: with a field, the timestep of the solver affects the last digits, and it is not
  // saved.
  nlohmann::json scene = scene_json();
  scene["forces"] = {{"evidence", {{"source", "intensities"}}}, {"smoothing", {{"weight", 0.5}, {"curvature", 0.5}}}};
  write_scene("scene.json", scene);
  const std::unique_ptr<Session> live = open();
  live->advance_steps(30);
  live->apply(RecordProfiles{0});
  live->advance_steps(30);  // a multiple of the refresh and rest intervals: both sessions continue at the same phase
  simplexseg::write_scene(path("saved.json"), live->scene());
  const std::unique_ptr<Session> reopened = open("saved.json");
  ASSERT_EQ(reopened->scene().meshes[0].mesh.positions, live->scene().meshes[0].mesh.positions);
  live->advance_steps(45);
  reopened->advance_steps(45);
  EXPECT_EQ(reopened->scene().meshes[0].mesh.positions, live->scene().meshes[0].mesh.positions);
  EXPECT_EQ(reopened->scene().meshes[0].previous, live->scene().meshes[0].previous);
}

TEST_F(Run, FractionsAndLabelsGetTheGridOfAnotherVolume) {
  const VolumeGeometry fine = read_volume(path("image.nii.gz")).geometry();
  VolumeGeometry coarse = fine;
  coarse.spacing_mm *= 1.7;
  for (int& size : coarse.size) size = size * 2 / 3;
  write_volume(path("coarse.nii"), Volume(coarse, VoxelType::UInt8));
  succeed(run({"--labels", path("fine.nii"), "--fractions", path("fine")}));
  succeed(run({"--labels", path("on_coarse.nii"), "--fractions", path("on_coarse"), "--grid", path("coarse.nii")}));
  const Volume fractions = read_volume(path("on_coarse/ball.nii.gz")), labels = read_volume(path("on_coarse.nii"));
  EXPECT_TRUE(fractions.geometry().same_grid(coarse));
  EXPECT_TRUE(labels.geometry().same_grid(coarse));
  const double volume = content_mm3(read_volume(path("fine/ball.nii.gz")));
  const int label = load_scene(path("scene.json")).scene.meshes.at(0).label;
  EXPECT_NEAR(content_mm3(read_volume(path("fine.nii"))) / label, volume, 0.01 * volume);
  EXPECT_NEAR(content_mm3(fractions), volume, 0.01 * volume);
  EXPECT_NEAR(content_mm3(labels) / label, volume, 0.15 * volume);
  EXPECT_EQ(call({"run", path("scene.json"), "--grid", path("coarse.nii")}).status, 2) << "nothing to write";
  EXPECT_EQ(call({"run", path("scene.json"), "--labels", path("x.dcm"), "--grid", path("coarse.nii")}).status, 2);
  EXPECT_EQ(call({"run", path("scene.json"), "--labels", path("x.nii"), "--grid", path("missing.nii")}).status, 2);
}

TEST_F(Run, OutputsDoNotReplaceTheGridOrTheImageOfAScene) {
  fs::copy_file(path("truth.nii.gz"), path("grid.nii.gz"));
  const std::string grid = text_of("grid.nii.gz"), image = text_of("image.nii.gz");
  EXPECT_EQ(call({"run", path("scene.json"), "--grid", path("grid.nii.gz"), "--labels", path("grid.nii.gz")}).status,
            2);
  fs::create_directory(path("fractions"));
  fs::copy_file(path("grid.nii.gz"), path("fractions/ball.nii.gz"));
  EXPECT_EQ(call({"run", path("scene.json"), "--grid", path("fractions/ball.nii.gz"), "--fractions", path("fractions")})
                .status,
            2);
  EXPECT_EQ(text_of("fractions/ball.nii.gz"), grid);
  EXPECT_EQ(call({"measure", path("scene.json"), path("image.nii.gz")}).status, 2);
  EXPECT_EQ(call({"measure", path("scene.json"), path("scene.json")}).status, 2);
  EXPECT_EQ(text_of("grid.nii.gz"), grid);
  EXPECT_EQ(text_of("image.nii.gz"), image);
}

}  // namespace
}  // namespace simplexseg
