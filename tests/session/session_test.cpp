// SPDX-License-Identifier: Apache-2.0
// Commands and their errors, levels, settling, and parameter tables.
#include "session/session.h"

#include <cmath>
#include <limits>
#include <set>

#include "forces/force_list.h"
#include "image/metrics.h"
#include "image/rasterise.h"
#include "mesh/mesh_geometry.h"
#include "session/run_trace.h"
#include "session_fixture.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Tables, EachNameRefersToItsMember) {
  SimulationParameters p{};
  for (const ParameterInfo& info : simulation_table())
    value_of(p, simulation_index(info.name)) = static_cast<float>(simulation_index(info.name) + 1);
  auto expect = [](const char* name, float member) {
    EXPECT_EQ(member, static_cast<float>(simulation_index(name) + 1)) << name;
  };
  expect("timestep", p.timestep), expect("damping", p.damping), expect("limit_timestep", p.limit_timestep);
  expect("refresh_interval", p.refresh_interval), expect("start_vertices", p.start_vertices),
      expect("final_vertices", p.final_vertices);
  expect("finest_edge", p.finest_edge), expect("steps_per_level", p.steps_per_level),
      expect("rest_tolerance", p.rest_tolerance_voxels);
  expect("frame_budget", p.frame_budget_ms);
}

TEST(Tables, AreWellFormed) {
  std::vector<std::span<const ParameterInfo>> tables{simulation_table()};
  for (const ForceInfo& force : force_list()) {
    tables.push_back(force.parameters);
    EXPECT_STREQ(force.parameters[0].name, "weight");
    EXPECT_EQ(find_force(force.name), &force);
    EXPECT_EQ(&force, &force_list()[static_cast<int>(force.id)]);
  }
  for (const auto& table : tables) {
    std::set<std::string> names;
    for (const ParameterInfo& info : table) {
      EXPECT_TRUE(names.insert(info.name).second) << info.name;
      EXPECT_LE(info.minimum, info.default_value) << info.name;
      EXPECT_GE(info.maximum, info.default_value) << info.name;
      EXPECT_LT(info.minimum, info.maximum) << info.name;
      EXPECT_GT(std::string(info.doc).size(), 10u) << info.name;
      const std::string choices = info.choices;
      EXPECT_EQ(info.kind == ParameterKind::Choice, !choices.empty()) << info.name;
      if (info.kind == ParameterKind::Choice) {
        EXPECT_EQ(std::count(choices.begin(), choices.end(), '|'), static_cast<int>(info.maximum)) << info.name;
      }
    }
  }
}

TEST(SessionCommands, NamesLabelsAndColoursAreTheFirstUnused) {
  const auto session = open_session();  // one mesh, "ball"
  const ItemId ball = session->scene().meshes[0].id;
  const auto add = [&] { return session->scene().find_mesh(session->apply(AddMesh{"", {{3, 3, 3}, 8}, {}, 0})); };
  const ItemId first = add()->id;
  EXPECT_EQ(session->scene().find_mesh(first)->name, "mesh 1");
  session->apply(AddPoint{first, {1, 2, 3}});
  session->apply(AddPoint{first, {1, 2, 4}});
  const MeshItem* second = add();
  EXPECT_EQ(second->name, "mesh 2");
  const int label = second->label;
  const Colour colour = second->colour;
  const MeshItem* third = add();
  EXPECT_EQ(third->name, "mesh 3");
  session->apply(DeleteMesh{session->scene().find_mesh("mesh 2")->id});
  const MeshItem* again = add();
  EXPECT_EQ(again->name, "mesh 2");
  EXPECT_EQ(again->label, label);
  EXPECT_EQ(again->colour, colour);
  for (const MeshItem& a : session->scene().meshes)
    for (const MeshItem& b : session->scene().meshes) EXPECT_TRUE(a.id == b.id || !(a.colour == b.colour));
  session->apply(DeleteMesh{ball});
  EXPECT_EQ(add()->label, 5) << "1 remains the label of the name \"ball\"";
}

TEST(RunTrace, ADeletedMeshIsRemoved) {
  const auto session = open_session();
  const ItemId other = session->apply(AddMesh{"other", {{3, 3, 3}, 8}, {}, 0});
  RunTrace trace;
  session->advance_steps(3);
  trace.sample(*session, 0.1);
  ASSERT_NE(trace.of(other), nullptr);
  session->apply(DeleteMesh{other});
  trace.remove_deleted(session->scene());
  EXPECT_EQ(trace.of(other), nullptr);
  EXPECT_EQ(trace.meshes().size(), 1u);
}

TEST(SessionCommands, EachHasItsEffect) {
  const auto session = open_session();
  const ItemId ball = session->scene().meshes[0].id;
  const ItemId other = session->apply(AddMesh{"other", {{3, 3, 3}, 8}, Colour{1, 2, 3}, ball});
  ASSERT_NE(session->scene().find_mesh(other), nullptr);
  EXPECT_EQ(session->scene().find_mesh(other)->name, "other");
  EXPECT_EQ(session->scene().find_mesh(other)->colour, (Colour{1, 2, 3}));
  EXPECT_EQ(session->scene().find_mesh(other)->label, 2);
  EXPECT_NEAR(measure(session->scene().find_mesh(other)->mesh).volume_mm3, 4.0 / 3 * M_PI * 512, 60);
  session->apply(EditMesh{other, "renamed", Colour{9, 9, 9}, false, 7});
  const MeshItem* item = session->scene().find_mesh(other);
  EXPECT_EQ(item->name, "renamed");
  EXPECT_FALSE(item->visible);
  EXPECT_EQ(item->label, 7);
  EXPECT_EQ(item->colour, (Colour{9, 9, 9}));
  const int curvature = parameter_index("smoothing", "curvature");
  session->apply(SetForceParameter{other, ForceId::Smoothing, curvature, 0.25f});
  EXPECT_EQ(session->scene().find_mesh(other)->parameters.values[0][curvature], 0.25f);
  EXPECT_NE(session->scene().find_mesh(ball)->parameters.values[0][curvature], 0.25f);
  session->apply(SetForceParameter{0, ForceId::Smoothing, curvature, 0.75f});
  for (const MeshItem& each : session->scene().meshes) EXPECT_EQ(each.parameters.values[0][curvature], 0.75f);
  session->apply(SetSimulationParameter{simulation_index("damping"), 0.5f});
  EXPECT_EQ(session->scene().simulation.damping, 0.5f);
  const ItemId point = session->apply(AddPoint{ball, {1, 2, 3}});
  session->apply(MovePoint{point, {4, 5, 6}});
  EXPECT_EQ(session->scene().find_point(point)->position_mm, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(session->scene().find_point(point)->mesh, ball);
  session->apply(DeletePoint{point});
  EXPECT_EQ(session->scene().find_point(point), nullptr);
  session->advance_steps(7);
  session->apply(RecordProfiles{ball});
  const std::size_t recorded = session->scene().find_mesh(ball)->profiles.size();
  EXPECT_EQ(recorded, 320u * IntensityProfileForce::profile_length(session->scene().find_mesh(ball)->parameters));
  session->apply(RefineMesh{ball});
  EXPECT_EQ(session->scene().find_mesh(ball)->mesh.vertex_count(), 1280);
  EXPECT_EQ(session->scene().find_mesh(ball)->profiles.size(), 4 * recorded) << "inherited";
  EXPECT_EQ(session->scene().find_mesh(ball)->steps_at_level, 0);
  EXPECT_EQ(session->scene().find_mesh(other)->mesh.vertex_count(), 320);
  session->advance_steps(7);
  session->apply(ResetPose{ball});
  EXPECT_EQ(session->scene().find_mesh(ball)->mesh.vertex_count(), 320);
  EXPECT_NEAR(measure(session->scene().find_mesh(ball)->mesh).centroid_mm[1], -2, 1e-3);
  session->apply(DeleteMesh{other});
  EXPECT_EQ(session->scene().meshes.size(), 1u);
  EXPECT_EQ(session->log().size(), 12u);
  EXPECT_EQ(session->log()[8].steps, 7);
  EXPECT_EQ(session->log()[10].steps, 7);
  EXPECT_EQ(session->total_steps(), 14);
}

TEST(SessionCommands, AddedMeshUsesForcesOfTheSceneOrOfAnotherMesh) {
  Scene scene = ball_scene();
  set(scene.forces, {"smoothing", "weight", 0.125f});
  set(scene.meshes[0].parameters, {"smoothing", "weight", 0.25f});
  const auto session = open_session(1, scene);
  const ItemId like_none = session->apply(AddMesh{"a", {{0, 0, 0}, 5}, {}, 0});
  EXPECT_EQ(session->scene().find_mesh(like_none)->parameters.weight(ForceId::Smoothing), 0.125f);
  const ItemId like_ball = session->apply(AddMesh{"b", {{0, 0, 0}, 5}, {}, session->scene().meshes[0].id});
  EXPECT_EQ(session->scene().find_mesh(like_ball)->parameters.weight(ForceId::Smoothing), 0.25f);
}

TEST(SessionCommands, InvalidCommandsAreRefusedAndChangeNothing) {
  const auto session = open_session();
  const ItemId ball = session->scene().meshes[0].id;
  const ItemId point = session->apply(AddPoint{ball, {0, 0, 20}});
  session->advance_steps(5);
  session->apply(EditMesh{ball, {}, {}, false, {}});
  session->apply(Undo{});
  constexpr ItemId kNone = 999;
  EXPECT_NE(refusal(*session, AddMesh{"far", {{500, 0, 0}, 5}, {}, 0}).find("outside"), std::string::npos);
  refusal(*session, AddMesh{"none", {{0, 0, 0}, 0}, {}, 0});
  refusal(*session, AddMesh{"negative", {{0, 0, 0}, -3}, {}, 0});
  refusal(*session, AddMesh{"nan", {{0, kNaN, 0}, 3}, {}, 0});
  refusal(*session, AddMesh{"inf", {{0, 0, 0}, kInfinity}, {}, 0});
  refusal(*session, AddMesh{"ball", {{0, 0, 0}, 3}, {}, 0});
  refusal(*session, DeleteMesh{kNone});
  refusal(*session, DeleteMesh{0});
  refusal(*session, EditMesh{kNone, "x", {}, {}, {}});
  refusal(*session, EditMesh{0, "x", {}, {}, {}});
  refusal(*session, EditMesh{ball, "", {}, {}, {}});
  refusal(*session, EditMesh{ball, "other name", {}, {}, 0});
  refusal(*session, EditMesh{ball, {}, {}, {}, 65536});
  refusal(*session, SetForceParameter{kNone, ForceId::Smoothing, 0, 0.5f});
  refusal(*session, SetForceParameter{ball, ForceId::Smoothing, -1, 0.5f});
  refusal(*session, SetForceParameter{ball, ForceId::Smoothing, kMaxForceParameters, 0.5f});
  refusal(*session, SetSimulationParameter{-1, 0.5f});
  refusal(*session, SetSimulationParameter{static_cast<int>(simulation_table().size()), 0.5f});
  refusal(*session, AddPoint{kNone, {0, 0, 0}});
  refusal(*session, AddPoint{0, {0, 0, 0}});
  refusal(*session, AddPoint{ball, {0, 0, kNaN}});
  refusal(*session, AddPoint{ball, {0, 0, kInfinity}});
  refusal(*session, MovePoint{kNone, {0, 0, 0}});
  refusal(*session, MovePoint{point, {kNaN, 0, 0}});
  refusal(*session, DeletePoint{kNone});
  refusal(*session, DeletePoint{ball});
  refusal(*session, ResetPose{kNone});
  refusal(*session, RecordProfiles{kNone});
  refusal(*session, RefineMesh{kNone});
  // Refused commands leave no trace in the engine.
  const auto calm = open_session();
  calm->replay(session->log(), 30);
  session->advance_steps(30);
  EXPECT_TRUE(same_state(state_of(*session), state_of(*calm)));
}

TEST(SessionCommands, EveryParameterIsRefusedOutOfItsRange) {
  const auto session = open_session();
  const ItemId ball = session->scene().meshes[0].id;
  auto outside = [](const ParameterInfo& info) {
    return std::vector<float>{std::nextafter(info.minimum, -1e30f), std::nextafter(info.maximum, 1e30f),
                              static_cast<float>(kNaN), static_cast<float>(kInfinity)};
  };
  for (const ForceInfo& force : force_list())
    for (std::size_t k = 0; k < force.parameters.size(); ++k) {
      for (float value : outside(force.parameters[k]))
        EXPECT_NE(refusal(*session, SetForceParameter{ball, force.id, static_cast<int>(k), value})
                      .find(force.parameters[k].name),
                  std::string::npos);
      for (float value : {force.parameters[k].minimum, force.parameters[k].maximum})
        session->apply(SetForceParameter{ball, force.id, static_cast<int>(k), value});
    }
  for (std::size_t k = 0; k < simulation_table().size(); ++k)
    for (float value : outside(simulation_table()[k]))
      EXPECT_NE(refusal(*session, SetSimulationParameter{static_cast<int>(k), value}).find(simulation_table()[k].name),
                std::string::npos);
}

TEST(SessionCommands, IdsAreNeverUsedTwice) {
  const auto session = open_session();
  std::set<ItemId> seen{session->scene().meshes[0].id};
  auto expect_new = [&](ItemId id) { EXPECT_TRUE(seen.insert(id).second) << id; };
  expect_new(session->apply(AddMesh{"a", {{0, 0, 0}, 5}, {}, 0}));
  session->apply(Undo{});
  const ItemId b = session->apply(AddMesh{"b", {{0, 0, 0}, 5}, {}, 0});
  expect_new(b);
  const ItemId point = session->apply(AddPoint{b, {0, 0, 0}});
  expect_new(point);
  session->apply(DeletePoint{point});
  expect_new(session->apply(AddPoint{b, {0, 0, 0}}));
  session->apply(DeleteMesh{b});
  EXPECT_TRUE(session->scene().points.empty()) << "its points are deleted, too";
  expect_new(session->apply(AddMesh{"b", {{0, 0, 0}, 5}, {}, 0}));
}

TEST(SessionOpen, RefusesWithNothingChanged) {
  const auto session = open_session();
  session->advance_steps(5);
  const SessionState before = state_of(*session);
  auto refused = [&](const char* what, auto&& spoil) {
    Scene scene = ball_scene();
    spoil(scene);
    EXPECT_THROW(session->open(scene, phantom("flat").image), Error) << what;
    EXPECT_TRUE(same_state(state_of(*session), before)) << what;
  };
  refused("seed outside", [](Scene& s) { s.meshes[0].seed.centre_mm[0] = 40; });
  refused("seed not a number", [](Scene& s) { s.meshes[0].seed.centre_mm[0] = kNaN; });
  refused("radius 0", [](Scene& s) { s.meshes[0].seed.radius_mm = 0; });
  refused("weight negative", [](Scene& s) { s.meshes[0].parameters.values[0][0] = -1; });
  refused("weight not a number", [](Scene& s) { s.meshes[0].parameters.values[0][0] = static_cast<float>(kNaN); });
  refused("damping out of range", [](Scene& s) { s.simulation.damping = 1.5f; });
  refused("point of no mesh", [](Scene& s) { s.points.push_back({5, 77, {0, 0, 0}}); });
  refused("point not a number", [](Scene& s) { s.meshes[0].id = 1, s.points.push_back({5, 1, {0, kNaN, 0}}); });
  refused("id twice", [](Scene& s) { s.meshes[0].id = 1, s.meshes.push_back(s.meshes[0]), s.meshes[1].name = "b"; });
  refused("broken mesh", [](Scene& s) {
    s.meshes[0].mesh = make_sphere({0, 0, 0}, 5, 1), s.meshes[0].mesh.neighbours[0][0] = 0;
  });
  EXPECT_EQ(session->advance_steps(3).steps, 3);
}

TEST(SessionLevels, RefinesToTheFinalVerticesAndSettles) {
  for (bool per_level : {false, true}) {
    Scene scene = ball_scene();
    scene.simulation.start_vertices = 80, scene.simulation.final_vertices = 1280;
    scene.simulation.steps_per_level = per_level ? 50 : 100000;  // by number of steps, or by settling at each level
    scene.simulation.rest_tolerance_voxels = 0.01f;
    const auto session = open_session(1, scene);
    EXPECT_EQ(session->scene().meshes[0].mesh.vertex_count(), 80);
    const Advance advance = session->advance_steps(5000, true);
    EXPECT_TRUE(advance.at_rest);
    EXPECT_TRUE(advance.refined);
    EXPECT_LT(advance.steps, 5000);
    EXPECT_FALSE(advance.failure.has_value());
    const MeshItem& item = session->scene().meshes[0];
    EXPECT_EQ(item.mesh.vertex_count(), 1280);
    validate(item.mesh);
    const Phantom& truth = phantom("sphere", 100, 10);
    EXPECT_GT(dice(mask_of(truth.labels, 1), rasterise(item.mesh, truth.image.geometry())), 0.95);
    EXPECT_LT(session->mean_move_mm().at(0), 0.01f);
    EXPECT_EQ(session->advance_steps(10, true).steps, 0) << "settled until something changes";
    session->apply(AddPoint{item.id, {0, 0, 23}});
    EXPECT_GT(session->advance_steps(10, true).steps, 0);
  }
}

TEST(SessionLevels, RefinementKeepsProfilesAndRestartsTheCountOfSteps) {
  Scene scene = ball_scene();
  scene.simulation.steps_per_level = 20, scene.simulation.final_vertices = 5120;
  const auto session = open_session(1, scene);
  session->apply(RecordProfiles{0});
  const std::size_t recorded = session->scene().meshes[0].profiles.size();
  ASSERT_GT(recorded, 0u);
  session->advance_steps(30);
  EXPECT_EQ(session->scene().meshes[0].mesh.vertex_count(), 1280);
  EXPECT_EQ(session->scene().meshes[0].profiles.size(), 4 * recorded);
  EXPECT_EQ(session->scene().meshes[0].steps_at_level, 10) << "the next refinement is due in ten";
  session->advance_steps(10);
  EXPECT_EQ(session->scene().meshes[0].mesh.vertex_count(), 5120);
  EXPECT_EQ(session->scene().meshes[0].profiles.size(), 16 * recorded);
}

TEST(SessionLevels, SolverStatesArePreservedByALoad) {
  for (float source : {0.0f, 1.0f}) {
    Scene scene = ball_scene();
    scene.simulation.solver_choice = static_cast<float>(Solver::Automatic);
    scene.simulation.final_vertices = 320;
    set(scene.meshes[0].parameters, {"evidence", "source", source});
    const auto session = open_session(1, scene);
    const float guess = session->advance_steps(1).steps == 1 ? session->last_outcome().solver.at(0).min_eigenvalue : 0;
    session->advance_steps(40);
    const float estimate = session->last_outcome().solver.at(0).min_eigenvalue;
    ASSERT_NE(estimate, guess) << source;
    session->apply(AddMesh{"other", {{3, 3, 3}, 6}, {}, 0});
    session->advance_steps(1);
    EXPECT_EQ(session->last_outcome().solver.at(0).min_eigenvalue, estimate) << source;
  }
}

TEST(SessionLevels, AMeshFinerThanTheVoxelsIsNotCreated) {
  Scene scene = ball_scene();
  scene.simulation.start_vertices = 1280, scene.simulation.final_vertices = 20480, scene.simulation.finest_edge = 1;
  scene.simulation.steps_per_level = 10;
  scene.meshes[0].seed.radius_mm = 6;
  const auto session = open_session(1, scene);
  EXPECT_EQ(session->scene().meshes[0].mesh.vertex_count(), 320)
      << "edges of 1280 vertices would be shorter than a voxel";
}

/// Ball with a timestep far above its limit.
Scene unstable_scene() {
  Scene scene = ball_scene();
  scene.simulation.solver_choice = static_cast<float>(Solver::Verlet);
  scene.simulation.limit_timestep = 0, scene.simulation.timestep = 10, scene.simulation.damping = 0.2f;
  set(scene.meshes[0].parameters, {"smoothing", "weight", 10});
  set(scene.meshes[0].parameters, {"smoothing", "curvature", 1});
  set(scene.meshes[0].parameters, {"evidence", "weight", 0});
  return scene;
}

TEST(SessionCuts, NameMeshAndForceAndTheRunContinues) {
  const Scene scene = unstable_scene();
  const Eigen::Vector3d scene_centre = scene.meshes[0].seed.centre_mm;
  const double radius = scene.meshes[0].seed.radius_mm;
  const auto session = open_session(1, scene);
  const Advance advance = session->advance_steps(500);
  EXPECT_FALSE(advance.failure.has_value()) << *advance.failure;
  ASSERT_FALSE(advance.cuts.empty());
  for (const std::string& line : advance.cuts) {
    EXPECT_NE(line.find("ball"), std::string::npos) << line;
    EXPECT_NE(line.find("smoothing"), std::string::npos) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
  EXPECT_EQ(session->total_steps(), 500);
  const SimplexMesh& mesh = session->scene().meshes[0].mesh;
  EXPECT_TRUE(all_finite(mesh.positions));
  for (const Eigen::Vector3f& p : mesh.positions)
    EXPECT_LT((p.cast<double>() - scene_centre).norm(), 1.5 * radius) << "unstable steps were undone";
  EXPECT_EQ(session->last_outcome().folded_vertices.at(0), 0);
  // A timestep within the limit needs no cut.
  session->apply(SetSimulationParameter{simulation_index("limit_timestep"), 1});
  session->apply(ResetPose{0});
  EXPECT_TRUE(session->advance_steps(500).cuts.empty());
}

TEST(SessionCuts, DoNotDependOnTheStepsPerCall) {
  const auto whole = open_session(1, unstable_scene()), parts = open_session(1, unstable_scene());
  const Advance expected = whole->advance_steps(120);
  std::vector<std::string> cuts;
  for (int steps = 0; steps < 120;) {
    const Advance part = parts->advance_steps(std::min(7, 120 - steps));
    steps += part.steps;
    cuts.insert(cuts.end(), part.cuts.begin(), part.cuts.end());
  }
  EXPECT_EQ(cuts, expected.cuts);
  EXPECT_TRUE(same_bits(parts->scene().meshes[0].mesh.positions, whole->scene().meshes[0].mesh.positions));
}

}  // namespace
}  // namespace simplexseg
