// SPDX-License-Identifier: Apache-2.0
// Sleep of settled meshes: what wakes them, and that they are not stepped.
#include "session/mesh_sleep.h"
#include "mesh/mesh_geometry.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

/// Two meshes that start from different seeds of the same ball and use evidence from intensities.
Scene two_balls() {
  Scene scene = ball_scene();
  scene.meshes[0].id = 1;
  MeshItem other = scene.meshes[0];
  other.id = 2, other.name = "other", other.seed.radius_mm *= 0.8;
  scene.meshes.push_back(other);
  return scene;
}
std::unique_ptr<Session> open_and_settle() {
  auto session = std::make_unique<Session>(make_cpu_engine(1));
  session->open(two_balls(), ball_image());
  EXPECT_TRUE(session->advance_steps(3000, true).at_rest);
  return session;
}
const MeshItem& mesh(const Session& session, int k) { return session.scene().meshes.at(k); }
bool asleep(const Session& session, int k) { return session.scene_without_poses().meshes.at(k).sleep.asleep; }
std::uint64_t launches(const Session& session) {
  std::uint64_t sum = 0;
  for (const Engine::KernelCount& kernel : session.engine().kernel_counts()) sum += kernel.launches;
  return sum;
}

TEST(MeshSleep, SettledMeshesAreNotStepped) {
  const auto session = open_and_settle();
  EXPECT_TRUE(asleep(*session, 0) && asleep(*session, 1));
  const auto before = state_of(*session);
  const std::uint64_t launched = launches(*session);
  EXPECT_EQ(session->advance_steps(100).steps, 100);
  EXPECT_EQ(launches(*session), launched);
  EXPECT_TRUE(same_state(state_of(*session), before));
  EXPECT_GT(session->last_outcome().mean_edge_mm[0], 0);
}

TEST(MeshSleep, AMeshThatNeverStopsFallsAsleepAfterManySteps) {
  Session session(make_cpu_engine(1));
  session.open(two_balls(), ball_image());
  session.apply(SetSimulationParameter{simulation_index("solver"), 1});   // verlet
  session.apply(SetSimulationParameter{simulation_index("damping"), 0});  // oscillates about its targets
  session.advance_steps(2500);
  ASSERT_FALSE(asleep(session, 0) || asleep(session, 1));
  const float voxel_mm = static_cast<float>(session.volume().geometry().spacing_mm.minCoeff());
  const auto& move_mm = session.last_outcome().mean_move_mm;
  // The tolerance grows from half of the motion to twice the motion in 4,000 steps.
  session.apply(SetSimulationParameter{simulation_index("rest_tolerance"), 0.5f * move_mm[0] / voxel_mm});
  EXPECT_FALSE(session.advance_steps(1000, true).at_rest);
  const Advance rest = session.advance_steps(8000, true);
  EXPECT_TRUE(rest.at_rest);
  EXPECT_GT(rest.steps, 200);
}

TEST(MeshSleep, ACommandWakesOnlyTheMeshesOnWhichItActs) {
  const auto session = open_and_settle();
  const Positions other = mesh(*session, 1).mesh.positions, own = mesh(*session, 0).mesh.positions;
  session->apply(AddPoint{1, {24, 0, 0}, MarkKind::Boundary});
  EXPECT_FALSE(asleep(*session, 0));
  EXPECT_TRUE(asleep(*session, 1));
  EXPECT_TRUE(session->advance_steps(2000, true).at_rest);
  EXPECT_TRUE(asleep(*session, 0));
  EXPECT_GT(largest_distance(mesh(*session, 0).mesh.positions, own), 0.5);
  EXPECT_TRUE(same_bits(mesh(*session, 1).mesh.positions, other));
}

TEST(MeshSleep, WhatWakesAMesh) {
  const auto session = open_and_settle();
  const auto expect_woken = [&](bool first, bool second, const char* by) {
    EXPECT_EQ(asleep(*session, 0), !first) << by;
    EXPECT_EQ(asleep(*session, 1), !second) << by;
    session->advance_steps(3000, true);
    EXPECT_TRUE(asleep(*session, 0) && asleep(*session, 1)) << by;
  };
  session->apply(SetForceParameter{2, ForceId::Smoothing, 0, 5});
  expect_woken(false, true, "a force");
  session->apply(SetSimulationParameter{simulation_index("timestep"), 0.5f});
  expect_woken(true, true, "a simulation parameter");
  const ItemId point = session->apply(AddPoint{2, {22, 0, 0}, MarkKind::Boundary});
  expect_woken(false, true, "a new point");
  session->apply(MovePoint{point, {23, 0, 0}});
  expect_woken(false, true, "a moved point");
  session->apply(DeletePoint{point});
  expect_woken(false, true, "a deleted point");
  session->apply(EditMesh{1, {}, {}, {}, {}, true});
  expect_woken(true, false, "a lock");
  session->apply(EditMesh{1, "renamed", {}, false, {}});
  expect_woken(false, false, "nothing: a name and visibility do not act on the surface");
  session->apply(AddMesh{"third", {{0, 0, 0}, 5}, std::nullopt});
  EXPECT_TRUE(asleep(*session, 0) && asleep(*session, 1));
}

TEST(MeshSleep, ACommandOnAnotherMeshKeepsTheCountOfSteps) {
  Scene scene = two_balls();
  set(scene.meshes[0].parameters, {"evidence", "source", 0});
  Session session(make_cpu_engine(1));
  session.open(std::move(scene), ball_image());
  session.advance_steps(35);
  const auto steps = [&] { return session.scene_without_poses().meshes.at(0).sleep.awake_steps; };
  ASSERT_TRUE(session.scene_without_poses().meshes.at(0).field);
  EXPECT_EQ(steps(), 35);
  session.apply(AddPoint{2, {22, 0, 0}, MarkKind::Boundary});
  EXPECT_EQ(steps(), 35) << "it acts on the other mesh";
  Session again(make_cpu_engine(1));
  again.open(session.scene(), ball_image());
  EXPECT_EQ(again.scene_without_poses().meshes.at(0).sleep.awake_steps, 35);
  session.apply(SetForceParameter{1, ForceId::Smoothing, 0, 5});
  EXPECT_EQ(steps(), 0);
}

TEST(MeshSleep, AnUndoRestoresIt) {
  const auto session = open_and_settle();
  const Positions settled = mesh(*session, 0).mesh.positions;
  session->apply(AddPoint{1, {24, 0, 0}, MarkKind::Boundary});
  session->advance_steps(50);
  session->apply(Undo{});
  EXPECT_TRUE(asleep(*session, 0)) << "it had settled";
  session->advance_steps(50);
  EXPECT_TRUE(same_bits(mesh(*session, 0).mesh.positions, settled));
}

TEST(MeshSleep, AReopenedSceneSleepsUnlessItWasChanged) {
  const auto session = open_and_settle();
  Session again(make_cpu_engine(1));
  again.open(session->scene(), ball_image());
  EXPECT_TRUE(asleep(again, 0) && asleep(again, 1));
  EXPECT_EQ(again.advance_steps(100, true).steps, 0);
  EXPECT_GT(again.last_outcome().mean_edge_mm[0], 0) << "measured when it was loaded";
  Scene changed = session->scene();
  set(changed.meshes[0].parameters, {"smoothing", "weight", 5});
  again.open(std::move(changed), ball_image());
  EXPECT_FALSE(asleep(again, 0));
  EXPECT_TRUE(asleep(again, 1));
}

TEST(MeshSleep, AMeshThatWasWokenIsSteppedUntilItsMotionIsKnown) {
  const auto session = open_and_settle();
  session->advance_steps(9 - static_cast<int>(session->total_steps() % 10));
  session->apply(SetForceParameter{1, ForceId::Smoothing, 0, 5.0001f});
  session->advance_steps(1);
  EXPECT_EQ(session->total_steps() % 10, 0) << "a check";
  EXPECT_FALSE(asleep(*session, 0));
}

}  // namespace
}  // namespace simplexseg
