// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "io/scene/mesh_start.h"
#include "scene_files.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

/// Start from the mask of a network: a ball in an oblique box.
MeshStart start_by_network() {
  auto mask = std::make_shared<NetworkMask>();
  VolumeGeometry& box = mask->voxels.box;
  box.size = {9, 11, 10}, box.spacing_mm = {1, 0.9, 1.1}, box.origin_mm = {0.1, 1.0 / 3, -7};
  box.direction = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  for (int k = 0; k < 10; ++k)
    for (int j = 0; j < 11; ++j)
      for (int i = 0; i < 9; ++i)
        mask->voxels.voxels.push_back(Eigen::Vector3d(i - 4, j - 5, k - 4.5).norm() < 4 ? VoxelPaint::Inside
                                                                                        : VoxelPaint::None);
  mask->server = "https://host:1527", mask->network = "a \"quoted\" näme", mask->licence = "CC BY 4.0";
  mask->identity = identity_of(mask->voxels);
  return start_of_network(std::move(mask), 1.0 / 3).start;
}

TEST_F(SceneIo, ALogRestoresEveryCommandBitForBit) {
  const Eigen::Vector3d p(0.1, 1.0 / 3, -2.5e-310);
  std::mt19937 random(9);
  const SegmentCode code{{"SCT", "123037004", "Anatomical Structure"}, {"99X", "a b", "Ü"}, {"SCT", "7771000", "Left"}};
  std::vector<LogEntry> log = {
      {0, AddMesh{"a \"quoted\" näme", {p, 10.0 / 3}, Colour{1, 2, 3}, 7, {}, {}, {}, {p, -p, 2 * p}, {0.6, 0, 0.8}}},
      {3, AddMesh{"", {p, 1}, std::nullopt, 0, std::nullopt, {p, -p, p, -p}, code}},
      {1, DeleteMesh{4}},
      {2, EditMesh{5, "name", Colour{9, 8, 7}, false, 12, true, 0.25f, code}},
      {0, EditMesh{5, std::nullopt, std::nullopt, std::nullopt, std::nullopt}},
      {7, SetSimulationParameter{find_parameter(simulation_table(), "damping"), 0.1f, true}},
      {7, SetSimulationParameter{find_parameter(simulation_table(), "limit_timestep"), 0}},
      {1000000, AddPoint{5, p, MarkKind::Outside, 2, {0, 0, 0}, {p, -p}, PaintBrush::disc(p, 0.1)}},
      {1, MovePoint{6, p, true}},
      {1, MovePoint{6, -p, false}},
      {1, DeletePoint{6}},
      {1, ResetPose{0}},
      {1, RecordProfiles{1}},
      {0, DuplicateMesh{1}},
      {0, ReorderMesh{1, 2}},
      {0, SetParameters{3, any_forces(random), default_simulation_parameters()}},
      {1, RefineMesh{2}},
      {1, StartFieldComparison{8}},
      {31, CommitFieldComparison{9}},
      {1, EditVoxels{8, VoxelEdit::Margin, -1.0 / 3}},
      {1, EditVoxels{8, VoxelEdit::Subtract, 0, 5}},
      {1, AddPoint{5, p, MarkKind::Outside, 2, {0, 0, 0}, {p, -p}, PaintBrush::contour(p, 0), VoxelEdit::Freeze}},
      {1, AddLasso{8, MarkKind::Outside, {p, -p, {1, 2, 1.0 / 3}}, {0.6, 0, 0.8}, true}},
      {1, Undo{}},
      {1, Redo{}},
      {2, ChooseLabelPreset{"abdomen", {{"a \"b\"", 65535}, {"Ü", 1}}}},
      {2, ChooseLabelPreset{}},
      {1, SetIntensityRange{4, {-1.0 / 3, std::numeric_limits<double>::infinity()}, true}},
      {1, SetIntensityRange{4, {}}},
      {1, SetStart{4, start_by_network()}},
      {1, SetStart{4, {}}},
  };
  for (const ForceInfo& force : force_list())
    for (std::size_t k = 0; k < force.parameters.size(); ++k)
      log.push_back(
          {2, SetForceParameter{3, force.id, static_cast<int>(k), any_value(random, force.parameters[k]), k % 2 == 1}});
  write_log(folder_ / "log.json", log, 55, "scene.json");
  const LogFile file = read_log(folder_ / "log.json");
  EXPECT_EQ(file.trailing_steps, 55);
  EXPECT_EQ(file.scene, "scene.json");
  ASSERT_EQ(file.log.size(), log.size());

  const auto get = [&]<class C>(std::type_identity<C>, std::size_t at) {
    return std::pair(std::get<C>(log[at].command), std::get<C>(file.log[at].command));
  };
  for (std::size_t e = 0; e < log.size(); ++e) {
    EXPECT_EQ(log[e].steps, file.log[e].steps);
    ASSERT_EQ(log[e].command.index(), file.log[e].command.index()) << e;
  }
  for (const std::size_t at : {0u, 1u}) {
    const auto [a, b] = get(std::type_identity<AddMesh>{}, at);
    EXPECT_EQ(a.name, b.name);
    EXPECT_TRUE(same_bits(a.seed.centre_mm, b.seed.centre_mm));
    EXPECT_EQ(a.seed.radius_mm, b.seed.radius_mm);
    EXPECT_EQ(a.colour, b.colour);
    EXPECT_EQ(a.like, b.like);
    EXPECT_EQ(a.box_mm, b.box_mm);
    EXPECT_EQ(a.contour_mm, b.contour_mm);
    EXPECT_EQ(a.contour_normal, b.contour_normal);
    EXPECT_EQ(a.code, b.code);
  }
  for (const std::size_t at : {3u, 4u}) {
    const auto [a, b] = get(std::type_identity<EditMesh>{}, at);
    EXPECT_TRUE(a.mesh == b.mesh && a.name == b.name && a.colour == b.colour && a.visible == b.visible &&
                a.label == b.label && a.locked == b.locked && a.opacity == b.opacity && a.code == b.code);
  }
  for (const std::size_t at : {5u, 6u}) {
    const auto [a, b] = get(std::type_identity<SetSimulationParameter>{}, at);
    EXPECT_TRUE(a.parameter == b.parameter && same_bits(a.value, b.value) && a.continues == b.continues);
  }
  const auto [added, added_again] = get(std::type_identity<AddPoint>{}, 7);
  EXPECT_TRUE(added.mesh == added_again.mesh && same_bits(added.position_mm, added_again.position_mm));
  EXPECT_EQ(added_again.kind, MarkKind::Outside);
  EXPECT_EQ(added_again.path_mm, added.path_mm);
  EXPECT_EQ(added_again.brush, added.brush);
  for (const std::size_t at : {8u, 9u}) {
    const auto [a, b] = get(std::type_identity<MovePoint>{}, at);
    EXPECT_TRUE(a.point == b.point && a.continues == b.continues && same_bits(a.position_mm, b.position_mm));
  }
  EXPECT_EQ(std::get<DeleteMesh>(file.log[2].command).mesh, 4u);
  EXPECT_EQ(std::get<DeletePoint>(file.log[10].command).point, 6u);
  EXPECT_EQ(std::get<ResetPose>(file.log[11].command).mesh, 0u);
  EXPECT_EQ(std::get<RecordProfiles>(file.log[12].command).mesh, 1u);
  EXPECT_FALSE(std::get<RecordProfiles>(file.log[12].command).from_model);
  EXPECT_EQ(std::get<DuplicateMesh>(file.log[13].command).mesh, 1u);
  EXPECT_EQ(std::get<ReorderMesh>(file.log[14].command).mesh, 1u);
  EXPECT_EQ(std::get<ReorderMesh>(file.log[14].command).place, 2);
  const auto [all, all_again] = get(std::type_identity<SetParameters>{}, 15);
  EXPECT_TRUE(all.mesh == all_again.mesh && std::memcmp(&all.forces, &all_again.forces, sizeof all.forces) == 0);
  ASSERT_TRUE(all_again.simulation);
  EXPECT_EQ(std::memcmp(&*all.simulation, &*all_again.simulation, sizeof *all.simulation), 0);
  EXPECT_EQ(std::get<RefineMesh>(file.log[16].command).mesh, 2u);
  EXPECT_EQ(std::get<StartFieldComparison>(file.log[17].command).mesh, 8u);
  EXPECT_EQ(std::get<CommitFieldComparison>(file.log[18].command).mesh, 9u);
  for (const std::size_t at : {19u, 20u}) {
    const auto [a, b] = get(std::type_identity<EditVoxels>{}, at);
    EXPECT_TRUE(a.mesh == b.mesh && a.edit == b.edit && same_bits(a.size, b.size) && a.other == b.other) << at;
  }
  const auto [freeze, freeze_again] = get(std::type_identity<AddPoint>{}, 21);
  EXPECT_EQ(freeze.brush, freeze_again.brush);
  EXPECT_EQ(freeze.edit, freeze_again.edit);
  const auto [lasso, lasso_again] = get(std::type_identity<AddLasso>{}, 22);
  EXPECT_TRUE(lasso.mesh == lasso_again.mesh && lasso.kind == lasso_again.kind);
  EXPECT_EQ(lasso.contour_mm, lasso_again.contour_mm);
  EXPECT_EQ(lasso.normal, lasso_again.normal);
  EXPECT_TRUE(lasso_again.local);
  for (const std::size_t at : {25u, 26u}) {
    const auto [a, b] = get(std::type_identity<ChooseLabelPreset>{}, at);
    EXPECT_TRUE(a.preset == b.preset && a.by_name == b.by_name);
  }
  for (const std::size_t at : {27u, 28u}) {
    const auto [a, b] = get(std::type_identity<SetIntensityRange>{}, at);
    EXPECT_TRUE(a.mesh == b.mesh && a.range == b.range && a.continues == b.continues);
  }
  const auto [start, start_again] = get(std::type_identity<SetStart>{}, 29);
  EXPECT_EQ(start_again.mesh, 4u);
  ASSERT_TRUE(start_again.start && start_again.start->network);
  EXPECT_EQ(start_again.start->error_mm, start.start->error_mm);
  const NetworkMask &mask = *start.start->network, &mask_again = *start_again.start->network;
  EXPECT_TRUE(mask.server == mask_again.server && mask.network == mask_again.network &&
              mask.licence == mask_again.licence && mask.identity == mask_again.identity);
  EXPECT_EQ(mask.voxels.voxels, mask_again.voxels.voxels);
  EXPECT_TRUE(mask.voxels.box.same_grid(mask_again.voxels.box));
  EXPECT_EQ(start.start->mesh->positions, start_again.start->mesh->positions);
  EXPECT_EQ(get(std::type_identity<SetStart>{}, 30).second.mesh, 4u);
  EXPECT_FALSE(get(std::type_identity<SetStart>{}, 30).second.start);
  for (std::size_t at = 31; at < log.size(); ++at) {
    const auto [a, b] = get(std::type_identity<SetForceParameter>{}, at);
    EXPECT_TRUE(a.mesh == b.mesh && a.force == b.force && a.parameter == b.parameter && same_bits(a.value, b.value) &&
                a.continues == b.continues)
        << at;
  }
}

TEST_F(SceneIo, ALogRestoresMeasurements) {
  const std::vector<Eigen::Vector3d> points{{0.1, 1.0 / 3, -2.5e-310}, {1, 2, 3}, {4, 5, 6}};
  write_log(folder_ / "log.json",
            {{0, AddMeasurement{MeasurementKind::Angle, points, "Cobb"}},
             {1, AddMeasurement{MeasurementKind::Ellipse, points, ""}},
             {2, MoveMeasurement{7, points, true}},
             {3, MoveMeasurement{7, points}},
             {4, RenameMeasurement{7, "näme"}},
             {5, DeleteMeasurement{8}}},
            0, "");
  const std::vector<LogEntry> log = read_log(folder_ / "log.json").log;
  ASSERT_EQ(log.size(), 6u);
  const auto& add = std::get<AddMeasurement>(log[0].command);
  EXPECT_TRUE(add.kind == MeasurementKind::Angle && add.points_mm == points && add.name == "Cobb");
  const auto& unnamed = std::get<AddMeasurement>(log[1].command);
  EXPECT_TRUE(unnamed.kind == MeasurementKind::Ellipse && unnamed.name.empty());
  for (const std::size_t at : {2u, 3u}) {
    const auto& move = std::get<MoveMeasurement>(log[at].command);
    EXPECT_TRUE(move.measurement == 7 && move.points_mm == points && move.continues == (at == 2));
  }
  EXPECT_EQ(std::get<RenameMeasurement>(log[4].command).name, "näme");
  EXPECT_EQ(std::get<DeleteMeasurement>(log[5].command).measurement, 8u);
}

TEST_F(SceneIo, AnInvalidMeasurementIsRejected) {
  const std::string name = "\"name\": \"a\", ", points = "\"points_mm\": [[0, 0, 0], [1, 0, 0]]";
  const auto refused = [this](const std::string& measurement, const std::string& why) {
    const std::string message = refusal(scene_with("\"measurements\": [{" + measurement + "}]"));
    EXPECT_NE(message.find(why), std::string::npos) << message;
    EXPECT_EQ(message.empty(), why.empty()) << message;
  };
  refused(name + "\"kind\": \"ruler\", " + points, "");
  refused(name + "\"kind\": \"rule\", " + points, "ruler");
  refused(name + "\"kind\": \"angle\", " + points, "2 points instead of 3");
  refused(name + "\"kind\": \"ruler\", \"points_mm\": [[1, 0, 0], [1, 0, 0]]", "coincide");
  refused(name + "\"kind\": \"ellipse\", \"points_mm\": [[0, 0, 0], [1, 0, 0], [1, 1, 0]]", "not perpendicular");
  refused("\"kind\": \"ruler\", " + points, "name");
  refused(name + "\"colour\": 1, \"kind\": \"ruler\", " + points, "colour");
}

TEST_F(SceneIo, AnInvalidLogIsRejected) {
  const auto log_with = [](const std::string& entry) {
    return "{\"simplexseg_log\": 1, \"entries\": [" + entry + "], \"trailing_steps\": 0}";
  };
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"{\"simplexseg_log\": 1, \"entries\": []}", "trailing_steps"},
      {"{\"simplexseg_log\": 1, \"entries\": [], \"trailing_steps\": 1, \"x\": 1}", "'x'"},
      {log_with("{\"command\": \"undo\"}"), "after_steps"},
      {log_with("{\"after_steps\": -1, \"command\": \"undo\"}"), "after_steps"},
      {log_with("{\"after_steps\": 2147483648, \"command\": \"undo\"}"), "entries[0].after_steps"},
      {log_with("{\"after_steps\": 2147483647, \"command\": \"undo\"}"), "entries[0].after_steps"},
      {log_with(
           "{\"after_steps\": 600000000, \"command\": \"undo\"}, {\"after_steps\": 600000000, \"command\": \"undo\"}"),
       "entries[1].after_steps"},
      {"{\"simplexseg_log\": 1, \"entries\": [], \"trailing_steps\": 2000000000}", "trailing_steps"},
      {log_with(R"({"after_steps": 1, "command": "add_mesh", "centre_mm": [1, 2, 1e308], "radius_mm": 1})"),
       "centre_mm[2]"},
      {log_with(R"({"after_steps": 1, "command": "add_mesh", "centre_mm": [1, 2, 3], "radius_mm": 1e308})"),
       "radius_mm"},
      {log_with("{\"after_steps\": 1, \"command\": \"undoo\"}"), "'undo'"},
      {log_with("{\"after_steps\": 1, \"command\": \"undo\", \"mesh\": 1}"), "'mesh'"},
      {log_with("{\"after_steps\": 1, \"command\": \"move_point\", \"point\": 1}"), "position_mm"},
      {log_with("{\"after_steps\": 1, \"command\": \"move_point\", \"point\": 1, \"position_mm\": [1, 2, NaN]}"),
       "line 1"},
      {log_with("{\"after_steps\": 1, \"command\": \"delete_mesh\", \"mesh\": -1}"), "entries[0].mesh"},
      {log_with(
           R"({"after_steps": 1, "command": "set_force_parameter", "mesh": 0, "force": "gradient", "parameter": "wait", "value": 1})"),
       "'weight'"},
      {log_with(
           R"({"after_steps": 1, "command": "set_force_parameter", "mesh": 0, "force": "gradient", "parameter": "weight", "value": null})"),
       "value"},
  };
  for (const auto& [text, expected] : cases) {
    try {
      read_log(write("log.json", text));
      ADD_FAILURE() << text << " was accepted";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("log.json"), std::string::npos) << error.what();
    }
  }
}

TEST_F(SceneIo, ALogWithEarlierNamesOfCommandsIsRead) {
  write("log.json", R"({"simplexseg_log": 1, "trailing_steps": 0, "entries": [
      {"after_steps": 2, "command": "learn_field", "mesh": 3}, {"after_steps": 1, "command": "take_field"}]})");
  const LogFile file = read_log(folder_ / "log.json");
  ASSERT_EQ(file.log.size(), 2u);
  ASSERT_TRUE(std::holds_alternative<StartFieldUpdate>(file.log[0].command));
  EXPECT_EQ(std::get<StartFieldUpdate>(file.log[0].command).mesh, 3u);
  EXPECT_TRUE(std::holds_alternative<CommitFieldUpdate>(file.log[1].command));
}

}  // namespace
}  // namespace simplexseg
