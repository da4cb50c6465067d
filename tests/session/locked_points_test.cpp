// SPDX-License-Identifier: Apache-2.0
// Points, strokes, lassos, boxes and paint of a locked segmentation: none is added, moved, changed or deleted.
#include <cmath>

#include "session_fixture.h"

namespace simplexseg {
namespace {

EditMesh lock_of(const Session& session, bool locked) { return {first_mesh(session).id, {}, {}, {}, {}, locked}; }

/// Session with a point of each kind, a stroke, a lasso and paint.
std::unique_ptr<Session> open_with_points() {
  auto session = open_session();
  const ItemId mesh = first_mesh(*session).id;
  session->apply(AddPoint{mesh, {10, 0, 0}});
  session->apply(AddPoint{mesh, {0, 0, 0}, MarkKind::Inside});
  AddPoint stroke{mesh, {0, 18, 0}, MarkKind::Outside};
  stroke.path_mm = {{3, 0, 0}, {6, 0, 0}};
  session->apply(stroke);
  std::vector<Eigen::Vector3d> contour;
  for (int n = 0; n < 24; ++n) contour.emplace_back(12 * std::cos(n * M_PI / 12), 12 * std::sin(n * M_PI / 12), 0);
  session->apply(AddLasso{mesh, MarkKind::Inside, contour});
  session->apply(AddPoint{mesh, {0, 0, 8}, MarkKind::Inside, 3, {0, 0, 0}, {}, PaintBrush::ball()});
  return session;
}

TEST(LockedPoints, AreNeitherMovedNorChangedNorDeleted) {
  const auto session = open_with_points();
  session->apply(lock_of(*session, true));
  const std::vector<UserPoint> points = session->scene().points;
  ASSERT_EQ(points.size(), 5u);
  for (const UserPoint& point : points) {
    SCOPED_TRACE(point.id);
    const std::string locked = "segmentation 'ball': it is locked; unlock it first";
    EXPECT_EQ(refusal(*session, MovePoint{point.id, point.position_mm + Eigen::Vector3d(1, 0, 0)}), locked);
    EXPECT_EQ(refusal(*session, ResizePoint{point.id, 2}), locked);
    EXPECT_EQ(refusal(*session, DeletePoint{point.id}), locked);
  }
  EXPECT_NE(refusal(*session, DeletePoint{999}).find("no such point"), std::string::npos);
}

TEST(LockedPoints, ChangeAgainAfterUnlockingOrUndoOfTheLock) {
  const auto session = open_with_points();
  const SessionState unlocked = state_of(*session);
  const ItemId point = session->scene().points[1].id;
  session->apply(lock_of(*session, true));
  session->apply(lock_of(*session, false));
  session->apply(MovePoint{point, {2, 0, 0}});
  session->apply(DeletePoint{point});
  EXPECT_EQ(session->scene().find_point(point), nullptr);
  for (int n = 0; n < 4; ++n) session->apply(Undo{});
  EXPECT_TRUE(same_state(state_of(*session), unlocked));
  session->apply(DeletePoint{point});
  EXPECT_EQ(session->scene().points.size(), 4u);
}

TEST(LockedPoints, OfOtherSegmentationsChangeAndTheReplayHasTheSameBits) {
  const auto play = [](Session& session) {
    const ItemId ball = first_mesh(session).id;
    const ItemId other = session.apply(AddMesh{"other", Seed{{-20, 0, 0}, 4}, {}, ball});
    const ItemId mark = session.apply(AddPoint{other, {-20, 0, 0}, MarkKind::Inside});
    session.advance_steps(10);
    session.apply(lock_of(session, true));
    session.apply(MovePoint{mark, {-19, 1, 0}});
    session.advance_steps(10);
    EXPECT_FALSE(refusal(session, MovePoint{session.scene().points[0].id, {1, 1, 1}}).empty());
    session.apply(lock_of(session, false));
    session.apply(MovePoint{session.scene().points[0].id, {11, 1, 0}});
    session.advance_steps(10);
  };
  const auto live = open_session();
  live->apply(AddPoint{first_mesh(*live).id, {10, 0, 0}});
  play(*live);
  const auto replayed = open_session();
  replayed->replay(live->log(), live->steps_since_last_command());
  EXPECT_TRUE(same_state(state_of(*replayed), state_of(*live)));
}

}  // namespace
}  // namespace simplexseg
