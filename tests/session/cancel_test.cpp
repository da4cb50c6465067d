// SPDX-License-Identifier: Apache-2.0
// Cancelled updates of fields: by the user, by undo and by deletion; start, log and replay after them.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <random>
#include <thread>

#include "core/error.h"
#include "session/mesh_marks.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

bool is_cancelled(const Session& session) {
  return is_update_cancelled(session.scene(), first_mesh(session), session.volume());
}
bool last_is_cancel(const Session& session) {
  return std::holds_alternative<CancelFieldUpdate>(session.log().back().command);
}
/// Starts the update that is due. The update takes longer than these steps, so it is not committed.
void start_update(Session& session) { session.advance(0.001); }
void wait_for_solution(const Session& session) {
  const auto hung = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  while (session.solving_progress() < 1 && std::chrono::steady_clock::now() < hung)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  ASSERT_EQ(session.solving_progress(), 1.0f);
}
void expect_same_replay(const Session& live) {
  for (const int threads : {1, 2}) {
    const auto again = open_with_field(threads);
    again->replay(live.log(), live.steps_since_last_command());
    EXPECT_TRUE(same_state(state_of(*again), state_of(live))) << threads;
    EXPECT_EQ(again->log().size(), live.log().size());
    const std::vector<MeshItem>&meshes = live.scene().meshes, &replayed = again->scene().meshes;
    for (std::size_t m = 0; m < meshes.size() && m < replayed.size(); ++m)
      EXPECT_EQ(is_update_cancelled(again->scene(), replayed[m], ball_image()),
                is_update_cancelled(live.scene(), meshes[m], ball_image()));
  }
}

TEST(CancelledUpdates, KeepTheFormerFieldAndDoNotStartAgain) {
  const auto session = open_with_field();
  session->advance_steps(20);
  const auto before = first_mesh(*session).field;
  ASSERT_NE(before, nullptr);
  session->apply(AddPoint{first_mesh(*session).id, {14, 0, 0}, MarkKind::Outside});
  start_update(*session);
  ASSERT_EQ(session->solving_mesh(), first_mesh(*session).id);
  session->apply(CancelFieldUpdate{});
  EXPECT_EQ(session->solving_mesh(), 0u);
  EXPECT_TRUE(last_is_cancel(*session));
  EXPECT_TRUE(is_cancelled(*session));
  session->advance_steps(20);
  start_update(*session);
  EXPECT_EQ(session->solving_mesh(), 0u);
  EXPECT_EQ(first_mesh(*session).field, before);
  EXPECT_EQ(session->scene().points.size(), 1u) << "the mark remains";
}

TEST(CancelledUpdates, StartAgainWhenAMarkChanges) {
  const auto session = open_with_field();
  session->advance_steps(20);
  const ItemId mesh = first_mesh(*session).id;
  const ItemId point = session->apply(AddPoint{mesh, {14, 0, 0}, MarkKind::Outside});
  const auto cancel = [&] {
    start_update(*session);
    ASSERT_EQ(session->solving_mesh(), mesh);
    session->apply(CancelFieldUpdate{});
    start_update(*session);
    ASSERT_NE(session->solving_mesh(), mesh);
  };
  cancel();
  session->apply(MovePoint{point, {15, 0, 0}});
  cancel();
  session->apply(AddPoint{mesh, {0, -21, 0}, MarkKind::Inside});
  cancel();
  const ItemId other = session->apply(AddMesh{"other", {{23, 0, 0}, 2}, std::nullopt});
  cancel();  // the seed of the other mesh reaches the box of the field
  session->apply(EditMesh{mesh, "name", std::nullopt, std::nullopt, std::nullopt});
  session->advance_steps(1);
  EXPECT_TRUE(is_cancelled(*session)) << "a name is no mark";
  EXPECT_TRUE(session->scene().find_mesh(other)->has_field()) << "the other mesh is solved";
  session->apply(DeletePoint{point});
  session->advance_steps(1);
  EXPECT_FALSE(has_stale_field(session->scene(), first_mesh(*session), ball_image()));
}

TEST(CancelledUpdates, IncludeMarksThatWereAddedMeanwhile) {
  const auto session = open_with_field();
  session->advance_steps(20);
  session->apply(AddPoint{first_mesh(*session).id, {14, 0, 0}, MarkKind::Outside});
  start_update(*session);
  session->apply(AddPoint{first_mesh(*session).id, {0, -21, 0}, MarkKind::Inside});
  ASSERT_NE(session->solving_mesh(), 0u);
  session->apply(CancelFieldUpdate{});
  start_update(*session);
  EXPECT_EQ(session->solving_mesh(), 0u);
  EXPECT_TRUE(is_cancelled(*session));
}

TEST(CancelledUpdates, AreSolvedOnRequest) {
  const auto plain = open_with_field(), session = open_with_field();
  plain->advance_steps(1);
  start_update(*session);
  const std::vector<Eigen::Vector3f> start = first_mesh(*session).mesh.positions;
  session->apply(CancelFieldUpdate{});
  EXPECT_TRUE(session->advance_steps(50, true).at_rest) << "a mesh without a field settles";
  EXPECT_EQ(first_mesh(*session).field, nullptr);
  EXPECT_EQ(first_mesh(*session).mesh.positions, start);
  session->apply(RequestFieldUpdate{first_mesh(*session).id});
  EXPECT_FALSE(is_cancelled(*session));
  session->advance_steps(1);
  ASSERT_TRUE(first_mesh(*session).has_field());
  EXPECT_EQ(first_mesh(*session).field->values, first_mesh(*plain).field->values);
}

TEST(CancelledUpdates, OfAFirstFieldDoNotStartAgainBecauseOfAnotherSeed) {
  const auto session = open_with_field();
  start_update(*session);
  session->apply(CancelFieldUpdate{});
  const ItemId other = session->apply(AddMesh{"other", {{23, 0, 0}, 2}, std::nullopt});
  start_update(*session);
  EXPECT_EQ(session->solving_mesh(), other);
  session->advance_steps(1);
  EXPECT_EQ(first_mesh(*session).field, nullptr);
  EXPECT_TRUE(session->scene().find_mesh(other)->has_field());
}

TEST(CancelledUpdates, AReplayEndsInTheSameBits) {
  const auto live = open_with_field();
  live->advance_steps(30);
  const ItemId mesh = first_mesh(*live).id;
  live->apply(AddPoint{mesh, {14, 0, 0}, MarkKind::Outside});
  start_update(*live);
  ASSERT_NE(live->solving_mesh(), 0u);
  live->apply(CancelFieldUpdate{});
  live->advance_steps(25);
  expect_same_replay(*live);
  live->apply(RequestFieldUpdate{mesh});
  start_update(*live);
  ASSERT_NE(live->solving_mesh(), 0u);
  wait_for_solution(*live);  // a complete solution is discarded as well
  live->apply(CancelFieldUpdate{});
  live->apply(AddPoint{mesh, {0, -21, 0}, MarkKind::Inside});
  live->advance_steps(30);
  ASSERT_EQ(first_mesh(*live).field->marks.size(), 3u);
  live->apply(AddPoint{mesh, {0, 0, 21}, MarkKind::Inside});
  live->advance_steps(30);
  expect_same_replay(*live);
}

TEST(CancelledUpdates, UndoStopsTheUpdateOfAMark) {
  const auto live = open_with_field();
  live->advance_steps(20);
  const auto before = first_mesh(*live).field;
  live->apply(AddPoint{first_mesh(*live).id, {14, 0, 0}, MarkKind::Outside});
  start_update(*live);
  ASSERT_NE(live->solving_mesh(), 0u);
  live->apply(Undo{});
  live->finish_cancelled_update();
  EXPECT_EQ(live->solving_mesh(), 0u);
  EXPECT_TRUE(last_is_cancel(*live));
  EXPECT_EQ(first_mesh(*live).field, before);
  EXPECT_FALSE(has_stale_field(live->scene(), first_mesh(*live), ball_image()));
  live->advance_steps(20);
  expect_same_replay(*live);
  live->apply(Redo{});
  start_update(*live);
  EXPECT_NE(live->solving_mesh(), 0u) << "the mark is placed again";
  live->advance_steps(20);
  EXPECT_EQ(first_mesh(*live).field->marks.size(), 2u);
  expect_same_replay(*live);
}

TEST(CancelledUpdates, TheMarkOfAnUndoneUpdateCanBePlacedAgain) {
  const auto session = open_with_field();
  session->advance_steps(20);
  const AddPoint mark{first_mesh(*session).id, {14, 0, 0}, MarkKind::Outside, 2};
  session->apply(mark);
  start_update(*session);
  session->apply(Undo{});
  session->finish_cancelled_update();
  session->apply(mark);
  start_update(*session);
  EXPECT_NE(session->solving_mesh(), 0u);
}

TEST(CancelledUpdates, UndoOfACancelledMarkAndRedoKeepTheCancellation) {
  const auto session = open_with_field();
  session->advance_steps(20);
  session->apply(AddPoint{first_mesh(*session).id, {14, 0, 0}, MarkKind::Outside});
  start_update(*session);
  session->apply(CancelFieldUpdate{});
  session->apply(Undo{});
  EXPECT_FALSE(is_cancelled(*session));
  session->apply(Redo{});
  EXPECT_TRUE(is_cancelled(*session));
  start_update(*session);
  EXPECT_EQ(session->solving_mesh(), 0u);
}

TEST(CancelledUpdates, UndoOfANeighboursSeedStopsTheUpdate) {
  const auto session = open_with_field();
  session->advance_steps(20);
  const auto before = first_mesh(*session).field;
  session->apply(AddMesh{"other", {{23, 0, 0}, 2}, std::nullopt});
  start_update(*session);
  ASSERT_EQ(session->solving_mesh(), first_mesh(*session).id) << "the seed reaches the box of its field";
  session->apply(Undo{});
  session->finish_cancelled_update();
  EXPECT_EQ(session->solving_mesh(), 0u);
  EXPECT_EQ(first_mesh(*session).field, before);
}

TEST(CancelledUpdates, UndoOfAnotherActionDoesNotStopTheUpdate) {
  const auto session = open_with_field();
  session->advance_steps(20);
  session->apply(AddPoint{first_mesh(*session).id, {14, 0, 0}, MarkKind::Outside});
  start_update(*session);
  session->apply(EditMesh{first_mesh(*session).id, "name", std::nullopt, std::nullopt, std::nullopt});
  session->apply(Undo{});
  session->finish_cancelled_update();
  ASSERT_NE(session->solving_mesh(), 0u);
  session->apply(CommitFieldUpdate{});
  EXPECT_EQ(first_mesh(*session).field->marks.size(), 2u);
}

TEST(CancelledUpdates, DeletionStopsTheUpdate) {
  const auto live = open_with_field();
  live->advance_steps(20);
  const ItemId mesh = first_mesh(*live).id;
  live->apply(AddPoint{mesh, {14, 0, 0}, MarkKind::Outside});
  start_update(*live);
  ASSERT_NE(live->solving_mesh(), 0u);
  live->apply(DeleteMesh{mesh});
  live->finish_cancelled_update();
  EXPECT_EQ(live->solving_mesh(), 0u);
  EXPECT_TRUE(last_is_cancel(*live));
  live->apply(Undo{});
  live->advance_steps(20);
  EXPECT_EQ(first_mesh(*live).field->marks.size(), 2u) << "the restored mesh is solved";
  expect_same_replay(*live);
}

TEST(CancelledUpdates, AreRefusedWhenNothingIsSolved) {
  const auto session = open_with_field();
  EXPECT_NE(refusal(*session, CancelFieldUpdate{}).find("no field is being solved"), std::string::npos);
  EXPECT_NE(refusal(*session, RequestFieldUpdate{99}).find("99"), std::string::npos);
}

/// Random marks, cancellations, undo and redo during live updates. SIMPLEXSEG_SESSIONS: number of sessions.
TEST(CancelledUpdates, RandomSessionsReplayToTheSameBits) {
  const char* setting = std::getenv("SIMPLEXSEG_SESSIONS");
  const unsigned count = setting != nullptr ? static_cast<unsigned>(std::max(0, std::atoi(setting))) : 3;
  int cancelled = 0;
  for (unsigned seed = 0; seed < count; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    const auto session = open_with_field();
    for (int action = 0; action < 12; ++action) {
      const Scene& scene = session->scene();
      const ItemId mesh =
          scene.meshes.empty() ? ItemId{0} : scene.meshes[static_cast<std::size_t>(action) % scene.meshes.size()].id;
      const Eigen::Vector3d place(below(40) - 20, below(40) - 20, below(40) - 20);
      switch (mesh == 0 ? 3 : below(9)) {
        case 0:
        case 1:
          session->apply(AddPoint{mesh, place, below(2) ? MarkKind::Inside : MarkKind::Outside, 2});
          break;
        case 2:
          if (!scene.points.empty()) session->apply(MovePoint{scene.points[0].id, place});
          break;
        case 3:
          session->apply(Undo{});
          break;
        case 4:
          session->apply(Redo{});
          break;
        case 5:
          session->apply(RequestFieldUpdate{mesh});
          break;
        case 6:
          if (scene.meshes.size() < 3) session->apply(AddMesh{"", {place, 3}, std::nullopt});
          break;
        case 7:
          if (below(3) == 0) session->apply(DeleteMesh{mesh});
          break;
        default:
          session->advance_steps(1 + below(20));
      }
      start_update(*session);
      if (below(2) && session->solving_mesh() != 0) {
        if (below(2)) std::this_thread::sleep_for(std::chrono::milliseconds(below(30)));
        session->apply(CancelFieldUpdate{});
        ++cancelled;
      }
      session->advance(0.002);
    }
    session->advance_steps(10);
    expect_same_replay(*session);
  }
  if (count > 2) {
    EXPECT_GT(cancelled, 0);
  }
}

}  // namespace
}  // namespace simplexseg
