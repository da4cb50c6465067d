// SPDX-License-Identifier: Apache-2.0
// Preliminary fields: of a first update, solved in a box that still grows.
#include <algorithm>
#include <chrono>

#include "mesh/mesh_geometry.h"
#include "session/mesh_lifecycle.h"
#include "session/mesh_marks.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

double volume_of(const Session& session) { return measure(first_mesh(session).mesh).volume_mm3; }

/// Session that has run steps with the first preliminary field of its mesh.
std::unique_ptr<Session> open_with_preliminary_field(int steps) {
  auto session = open_with_field();
  const ItemId mesh = first_mesh(*session).id;
  session->replay({{0, StartFieldUpdate{mesh}}, {0, CommitPreliminaryField{}}}, steps);
  return session;
}

TEST(PreliminaryFields, MoveTheMeshDuringTheUpdate) {
  const double seed_mm3 = volume_of(*open_with_field());
  const auto session = open_with_preliminary_field(60);
  ASSERT_TRUE(first_mesh(*session).has_field());
  EXPECT_TRUE(first_mesh(*session).field->is_preliminary());
  EXPECT_EQ(session->solving_mesh(), first_mesh(*session).id) << "the update continues";
  EXPECT_GT(volume_of(*session), 1.2 * seed_mm3);
  const VoxelBox box = first_mesh(*session).field->box;
  const int vertices = first_mesh(*session).mesh.vertex_count();
  session->apply(CommitFieldUpdate{});
  EXPECT_FALSE(first_mesh(*session).field->is_preliminary());
  EXPECT_GT(first_mesh(*session).field->box.voxel_count(), box.voxel_count()) << "the box grew";
  EXPECT_EQ(first_mesh(*session).mesh.vertex_count(), vertices) << "no refinement for a preliminary field";
  const Advance done = session->advance_steps(800, true);
  EXPECT_TRUE(done.at_rest);
  EXPECT_NEAR(std::cbrt(volume_of(*session) * 3 / (4 * M_PI)), kPhantomRadius, 0.5);
}

TEST(PreliminaryFields, DoNotChangeTheFieldThatFollows) {
  const auto with = open_with_preliminary_field(20), without = open_with_field();
  with->apply(CommitFieldUpdate{});
  without->advance_steps(1);
  EXPECT_EQ(first_mesh(*with).field->values, first_mesh(*without).field->values);
  EXPECT_EQ(first_mesh(*with).field->marks, first_mesh(*without).field->marks);
}

TEST(PreliminaryFields, RemainAfterACancellationUntilTheUpdateIsRequested) {
  const auto session = open_with_preliminary_field(10);
  const auto field = first_mesh(*session).field;
  session->apply(CancelFieldUpdate{});
  EXPECT_TRUE(has_stale_field(session->scene(), first_mesh(*session), ball_image()));
  session->advance_steps(10);
  EXPECT_EQ(first_mesh(*session).field, field) << "the user has cancelled the update";
  session->apply(RequestFieldUpdate{first_mesh(*session).id});
  session->advance_steps(10);
  EXPECT_FALSE(first_mesh(*session).field->is_preliminary());
}

TEST(PreliminaryFields, UndoOfAnotherActionDoesNotStopTheUpdate) {
  const auto session = open_with_preliminary_field(10);
  session->apply(EditMesh{first_mesh(*session).id, "name", std::nullopt, std::nullopt, std::nullopt});
  session->apply(Undo{});
  session->finish_cancelled_update();
  ASSERT_NE(session->solving_mesh(), 0u);
  session->apply(CommitFieldUpdate{});
  EXPECT_EQ(first_mesh(*session).field->marks.size(), 1u);
}

TEST(PreliminaryFields, AreCommittedLiveAndReplayedToTheSameBits) {
  const auto live = open_with_field();
  const auto hung = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  do live->advance(0.002);
  while ((!first_mesh(*live).has_field() || first_mesh(*live).field->is_preliminary()) &&
         std::chrono::steady_clock::now() < hung);
  for (int frame = 0; frame < 20; ++frame) live->advance(0.002);
  const auto first = [&]<class C>(std::type_identity<C>) {
    return std::find_if(live->log().begin(), live->log().end(),
                        [](const LogEntry& entry) { return std::holds_alternative<C>(entry.command); });
  };
  ASSERT_NE(first(std::type_identity<CommitFieldUpdate>()), live->log().end());
  EXPECT_LT(first(std::type_identity<CommitPreliminaryField>()), first(std::type_identity<CommitFieldUpdate>()));
  for (const int threads : {1, 2}) {
    const auto again = open_with_field(threads);
    again->replay(live->log(), live->steps_since_last_command());
    EXPECT_TRUE(same_state(state_of(*again), state_of(*live))) << threads;
  }
}

TEST(PreliminaryFields, OfAnEndedUpdateAreNone) {
  const auto session = open_with_field();
  EXPECT_NE(refusal(*session, CommitPreliminaryField{}).find("no field is being solved"), std::string::npos);
  session->advance_steps(1);
  const ItemId mesh = first_mesh(*session).id;
  session->apply(AddPoint{mesh, {14, 0, 0}, MarkKind::Outside});
  const auto before = first_mesh(*session).field;
  session->apply(StartFieldUpdate{mesh});
  session->apply(CommitPreliminaryField{});
  EXPECT_EQ(first_mesh(*session).field, before) << "only the first update of a mesh has preliminary fields";
}

}  // namespace
}  // namespace simplexseg
