// SPDX-License-Identifier: Apache-2.0
// Undo, redo and replay, bit for bit.
#include <random>

#include "session/session.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

TEST(SessionUndo, EveryCommandIsUndoneAndRedone) {
  const auto session = open_session();
  const ItemId ball = session->scene().meshes[0].id;
  const ItemId point = session->apply(AddPoint{ball, {0, 0, 18}});
  const ItemId inside = session->apply(AddPoint{ball, {1, 0, 2}, MarkKind::Inside, 2});
  const ItemId ruler = session->apply(AddMeasurement{MeasurementKind::Ruler, {{0, 0, 0}, {3, 4, 0}}, ""});
  session->advance_steps(12);
  const std::vector<Command> commands{
      AddMeasurement{MeasurementKind::Ellipse, {{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}, "liver"},
      MoveMeasurement{ruler, {{1, 1, 0}, {3, 4, 0}}},
      RenameMeasurement{ruler, "width"},
      DeleteMeasurement{ruler},
      AddMesh{"other", {{3, 3, 3}, 8}, {}, 0},
      EditMesh{ball, "renamed", {}, false, 9},
      SetForceParameter{ball, ForceId::Smoothing, 0, 0.125f},
      SetForceParameter{0, ForceId::Evidence, 0, 0.25f},
      SetSimulationParameter{simulation_index("damping"), 0.75f},
      AddPoint{ball, {5, 5, 17}},
      MovePoint{point, {0, 3, 19}},
      ResizePoint{inside, 3.5},
      SetReference{ball, Reference{"truth.nii.gz", 3}},
      RecordProfiles{0},
      RefineMesh{ball},
      DuplicateMesh{ball},
      ReorderMesh{ball, 1},
      SetParameters{0, default_force_parameters(), default_simulation_parameters()},
      ResetPose{ball},
      DeletePoint{point},
      DeleteMesh{ball},
  };
  std::vector<SessionState> before, after;
  for (const Command& command : commands) {
    session->advance_steps(4);  // the pose changes between commands
    before.push_back(state_of(*session));
    session->apply(command);
    after.push_back(state_of(*session));
    EXPECT_STREQ(session->undo_title(), title_of(command));
    // Undo and redo of the last command ...
    session->apply(Undo{});
    EXPECT_TRUE(same_state(state_of(*session), before.back())) << title_of(command);
    EXPECT_STREQ(session->redo_title(), title_of(command));
    session->apply(Redo{});
    EXPECT_TRUE(same_state(state_of(*session), after.back())) << title_of(command);
  }
  // ... and of all commands, with steps in between.
  for (std::size_t k = commands.size(); k-- > 0;) {
    session->advance_steps(3);
    session->apply(Undo{});
    EXPECT_TRUE(same_state(state_of(*session), before[k])) << title_of(commands[k]);
  }
  EXPECT_TRUE(session->can_undo()) << "the first point";
  // Each redo restores the pose at which its command was undone.
  for (const Command& command : commands) {
    EXPECT_STREQ(session->redo_title(), title_of(command));
    session->apply(Redo{});
  }
  EXPECT_FALSE(session->can_redo());
  EXPECT_EQ(session->scene().find_mesh(ball), nullptr);
}

TEST(SessionUndo, TwoHundredMixedActionsAndBack) {
  const auto session = open_session();
  const ItemId ball = session->scene().meshes[0].id;
  std::vector<SessionState> before;
  std::mt19937 random(4);
  const auto below = [&random](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  const auto place = [&] { return Eigen::Vector3d(below(40) - 20, below(40) - 20, below(40) - 20); };
  const auto any_command = [&]() -> Command {
    const std::vector<UserPoint>& points = session->scene().points;
    const std::vector<MeshItem>& meshes = session->scene().meshes;
    const ItemId mesh = meshes[below(static_cast<int>(meshes.size()))].id;
    switch (below(9)) {
      case 0:
        return SetForceParameter{mesh, ForceId::Smoothing, 0, 0.1f + 0.1f * static_cast<float>(below(8))};
      case 1:
        if (meshes.size() < 3) return AddMesh{"", {place() / 4, 5}, {}, 0};
        return ReorderMesh{mesh, below(3)};
      case 2:
        if (meshes.size() > 1 && mesh != ball) return DeleteMesh{mesh};
        return EditMesh{mesh, {}, {}, below(2) == 0, 1 + below(9)};
      case 3:
        if (meshes.size() < 3) return DuplicateMesh{mesh};
        return RecordProfiles{mesh};
      case 4:
        return ResetPose{mesh};
      case 5:
        if (!points.empty()) return DeletePoint{points[below(static_cast<int>(points.size()))].id};
        [[fallthrough]];
      case 6:
        if (!points.empty()) return MovePoint{points[below(static_cast<int>(points.size()))].id, place()};
        [[fallthrough]];
      default:
        return AddPoint{mesh, place()};
    }
  };
  constexpr int kActions = 200;
  for (int n = 0; n < kActions; ++n) {
    session->advance_steps(below(3));
    before.push_back(state_of(*session));
    session->apply(any_command());
  }
  before.push_back(state_of(*session));
  for (int n = kActions - 1; n >= 0; --n) {
    session->apply(Undo{});
    ASSERT_TRUE(same_state(state_of(*session), before[static_cast<std::size_t>(n)])) << n;
  }
  EXPECT_FALSE(session->can_undo());
  for (int n = 1; n <= kActions; ++n) {
    session->apply(Redo{});
    ASSERT_TRUE(same_state(state_of(*session), before[static_cast<std::size_t>(n)])) << n;
  }
}

TEST(SessionUndo, TheEngineIsRestored) {
  // After undo the simulation continues like a session opened on that state.
  const auto session = open_session();
  session->advance_steps(20);
  session->apply(SetForceParameter{0, ForceId::Evidence, 0, 0.0f});
  session->advance_steps(20);
  session->apply(Undo{});
  Scene scene = session->scene();
  const auto fresh = open_session(1, scene);
  session->advance_steps(9);
  fresh->advance_steps(9);
  EXPECT_TRUE(same_state(state_of(*session), state_of(*fresh)));
}

TEST(SessionUndo, WithNothingToUndo) {
  const auto session = open_session();
  const SessionState before = state_of(*session);
  EXPECT_FALSE(session->can_undo());
  EXPECT_FALSE(session->can_redo());
  EXPECT_STREQ(session->undo_title(), "");
  session->apply(Undo{});
  session->apply(Redo{});
  EXPECT_TRUE(same_state(state_of(*session), before));

  Session empty(make_cpu_engine(1));
  empty.apply(Undo{});
  empty.apply(Redo{});
  EXPECT_EQ(empty.advance_steps(5).steps, 5);
  EXPECT_THROW(empty.apply(EditMesh{0, "x", {}, {}, {}}), Error);
  EXPECT_THROW(empty.apply(RecordProfiles{1}), Error);
  empty.apply(SetForceParameter{0, ForceId::Smoothing, 0, 0.5f});
  empty.apply(AddMesh{"", {{0, 0, 0}, 10}, {}, 0});  // also without a volume
  EXPECT_EQ(empty.scene().meshes.size(), 1u);
  empty.apply(Undo{});
  EXPECT_TRUE(empty.scene().meshes.empty());
  EXPECT_EQ(empty.advance_steps(5).steps, 5);
}

TEST(SessionUndo, ADeletedMeshIsRestoredWithItsPoints) {
  const auto session = open_session();
  const ItemId ball = session->scene().meshes[0].id;
  session->apply(AddMesh{"other", {{0, 0, 0}, 6}, {}, 0});
  session->apply(AddPoint{ball, {0, 0, 21}});
  session->apply(AddPoint{ball, {0, 21, 0}});
  session->advance_steps(15);
  const SessionState before = state_of(*session);
  session->apply(DeleteMesh{ball});
  EXPECT_TRUE(session->scene().points.empty());
  session->advance_steps(15);
  session->apply(Undo{});
  EXPECT_TRUE(same_state(state_of(*session), before));
  // The points attract again.
  const auto calm = open_session(1, session->scene());
  session->advance_steps(30);
  calm->advance_steps(30);
  EXPECT_TRUE(same_state(state_of(*session), state_of(*calm)));
}

TEST(SessionUndo, FurtherCommandsClearRedo) {
  const auto session = open_session();
  session->apply(SetForceParameter{0, ForceId::Smoothing, 0, 0.1f});
  session->apply(Undo{});
  session->apply(SetForceParameter{0, ForceId::Evidence, 0, 0.1f});
  EXPECT_FALSE(session->can_redo());
  session->apply(Redo{});
  EXPECT_NE(session->scene().meshes[0].parameters.weight(ForceId::Smoothing), 0.1f);
}

TEST(SessionUndo, OneSliderMovementIsOneUnit) {
  const auto session = open_session();
  const SessionState before = state_of(*session);
  for (float value : {0.1f, 0.2f, 0.3f}) {
    session->apply(SetForceParameter{0, ForceId::Smoothing, 0, value, value > 0.1f});
    session->advance_steps(3);
  }
  session->apply(SetForceParameter{0, ForceId::Evidence, 0, 0.7f});
  session->apply(Undo{});
  EXPECT_EQ(session->scene().meshes[0].parameters.weight(ForceId::Smoothing), 0.3f);
  session->apply(Undo{});
  EXPECT_TRUE(same_state(state_of(*session), before));
}

TEST(SessionUndo, TwoSliderMovementsAreTwoUnits) {
  const auto session = open_session();
  session->apply(SetForceParameter{0, ForceId::Smoothing, 0, 0.1f});
  session->advance_steps(500);
  const SessionState between = state_of(*session);
  ASSERT_EQ(session->scene().meshes[0].mesh.vertex_count(), 1280);
  session->apply(SetForceParameter{0, ForceId::Smoothing, 0, 0.2f});
  session->apply(SetForceParameter{0, ForceId::Smoothing, 0, 0.3f, true});
  session->apply(Undo{});
  EXPECT_TRUE(same_state(state_of(*session), between));
}

/// Drag from the surface outwards: the press and 30 moves, each followed by `advance`.
template <class Steps>
ItemId drag(Session& session, const Steps& steps) {
  const ItemId ball = session.scene().meshes[0].id;
  const Eigen::Vector3d start = 12.2 * Eigen::Vector3d(0.6, 0, 0.8) + Eigen::Vector3d(1, -2, 0.5);
  const ItemId point = session.apply(AddPoint{ball, start});
  for (int k = 1; k <= 30; ++k) {
    steps();
    session.apply(MovePoint{point, start + 0.25 * k * Eigen::Vector3d(0.6, 0.05, 0.8), true});
  }
  steps();
  return point;
}

TEST(SessionReplay, ADragIsOneUnitOfUndo) {
  const auto session = open_session();
  session->advance_steps(33);
  const SessionState before = state_of(*session);
  drag(*session, [&] { session->advance_steps(3); });
  const SessionState after = state_of(*session);
  ASSERT_FALSE(same_state(after, before));
  session->apply(Undo{});
  EXPECT_TRUE(same_state(state_of(*session), before));
  EXPECT_FALSE(session->can_undo());
  session->apply(Redo{});
  EXPECT_TRUE(same_state(state_of(*session), after));
  // A second drag of the same point is a separate unit.
  const ItemId point = session->scene().points[0].id;
  session->apply(MovePoint{point, {0, 0, 22}, false});
  for (int k = 1; k <= 5; ++k) session->apply(MovePoint{point, {0, 0, 22.0 + k}, true});
  session->apply(Undo{});
  EXPECT_TRUE(same_state(state_of(*session), after));
}

TEST(SessionReplay, ALiveDragGivesTheSameBitsOnAnyNumberOfThreads) {
  // Timed by the clock, with a refinement after 100 steps.
  Scene scene = ball_scene();
  scene.simulation.final_vertices = 5120;
  const auto live = open_session(2, scene);
  live->advance_steps(60);
  drag(*live, [&] { live->advance(0.002); });
  live->apply(SetForceParameter{0, ForceId::Smoothing, 0, 0.75f});
  live->advance(0.02);
  live->apply(Undo{});
  live->advance(0.01);
  live->apply(Redo{});
  live->advance(0.05);
  live->advance_steps(120);
  EXPECT_GT(live->scene().meshes[0].mesh.vertex_count(), 320);
  int steps = live->steps_since_last_command();
  for (const LogEntry& entry : live->log()) steps += entry.steps;
  EXPECT_EQ(steps, live->total_steps());
  for (int threads : {1, 2, 1}) {
    const auto replayed = open_session(threads, scene);
    replayed->replay(live->log(), live->steps_since_last_command());
    EXPECT_TRUE(same_state(state_of(*replayed), state_of(*live))) << threads << " threads";
    EXPECT_EQ(replayed->total_steps(), live->total_steps());
    EXPECT_EQ(replayed->log().size(), live->log().size());
    EXPECT_EQ(replayed->can_undo(), live->can_undo());
  }
}

TEST(SessionReplay, ReadingChangesNothing) {
  // Reads poses and plans between batches of any size, as the window does.
  const auto quiet = open_session(), watched = open_session();
  quiet->advance_steps(230);
  for (int k = 0; k < 230;) {
    const int batch = 1 + k % 7;
    k += watched->advance_steps(std::min(batch, 230 - k)).steps;
    (void)state_of(*watched);
    (void)watched->plan();
  }
  EXPECT_TRUE(same_state(state_of(*quiet), state_of(*watched)));
}

TEST(SessionReplay, AnotherEngineContinues) {
  const auto session = open_session();
  session->advance_steps(40);
  const SessionState before = state_of(*session);
  session->set_engine(make_cpu_engine(2));
  EXPECT_TRUE(same_state(state_of(*session), before));
  EXPECT_EQ(session->advance_steps(40).steps, 40);
}

TEST(SessionReplay, TheRevisionCountsChanges) {
  const auto session = open_session();
  auto changed = [&, last = session->revision()]() mutable {
    return std::exchange(last, session->revision()) != session->revision();
  };
  EXPECT_FALSE(changed());
  (void)session->scene();
  EXPECT_FALSE(changed());
  session->advance_steps(1);
  EXPECT_TRUE(changed());
  session->apply(EditMesh{session->scene().meshes[0].id, {}, {}, false, {}});
  EXPECT_TRUE(changed());
  session->apply(Undo{});
  EXPECT_TRUE(changed());
}

}  // namespace
}  // namespace simplexseg
