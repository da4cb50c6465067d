// SPDX-License-Identifier: Apache-2.0
// Fields solved from the marks of a scene: when, from which marks, and with undo and replay.
#include <chrono>
#include <thread>

#include "core/error.h"
#include "field/evidence_field.h"
#include "forces/force_list.h"
#include "image/rasterise.h"
#include "mesh/mesh_geometry.h"
#include "session/mesh_lifecycle.h"
#include "session/mesh_marks.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

/// Foreground probability at a position, from its nearest voxel; 0 outside the box.
double field_at(const MeshItem& item, const Eigen::Vector3d& mm) {
  const Eigen::Vector3d at = ball_image().geometry().index_from_world() * mm;
  std::array<int, 3> v{};
  for (int a = 0; a < 3; ++a) {
    v[a] = static_cast<int>(std::lround(at[a])) - item.field->box.first[a];
    if (v[a] < 0 || v[a] >= item.field->box.size[a]) return 0;
  }
  const auto& size = item.field->box.size;
  return item.field->values[(std::size_t(v[2]) * size[1] + v[1]) * size[0] + v[0]] / 65535.0;
}

TEST(Fields, AreSolvedBeforeTheFirstStepAndAttractTheMesh) {
  const auto session = open_with_field();
  EXPECT_EQ(first_mesh(*session).field, nullptr);
  const Advance done = session->advance_steps(600, true);
  EXPECT_TRUE(done.at_rest);
  EXPECT_TRUE(done.warnings.empty());
  ASSERT_TRUE(first_mesh(*session).has_field());
  EXPECT_GT(field_at(first_mesh(*session), {10, 0, 0}), 0.9);
  EXPECT_LT(field_at(first_mesh(*session), {27, 0, 0}), 0.1);
  const double radius = std::cbrt(measure(first_mesh(*session).mesh).volume_mm3 * 3 / (4 * M_PI));
  EXPECT_NEAR(radius, kPhantomRadius, 0.5);
}

TEST(Fields, OnlyNeededFieldsAreSolved) {
  const auto session = open_with_field();
  session->apply(SetForceParameter{0, ForceId::Evidence, EvidenceForce::weight, 0});
  session->advance_steps(20);
  EXPECT_EQ(first_mesh(*session).field, nullptr);
  session->apply(SetForceParameter{0, ForceId::Evidence, EvidenceForce::weight, 0.5f});
  session->apply(SetForceParameter{0, ForceId::Evidence, EvidenceForce::source, 1});
  session->advance_steps(20);
  EXPECT_EQ(first_mesh(*session).field, nullptr);
  session->apply(SetForceParameter{0, ForceId::Evidence, EvidenceForce::source, 0});
  session->advance_steps(20);
  EXPECT_TRUE(first_mesh(*session).has_field());
}

TEST(Fields, PointsAreMarksAndAMeshEndsOnTheirSide) {
  const auto session = open_with_field();
  session->advance_steps(400, true);
  const ItemId mesh = first_mesh(*session).id;
  const Eigen::Vector3d too_much(17.5, 0, 0), too_little(0, -21, 0);
  session->apply(AddPoint{mesh, too_much, MarkKind::Outside});
  session->apply(AddPoint{mesh, too_little, MarkKind::Inside});
  const UserPoint& point = session->scene().points.back();
  EXPECT_GT(point.radius_mm, 1.5);
  EXPECT_EQ(marks_of(session->scene(), first_mesh(*session), ball_image()).size(), 3u);
  session->advance_steps(600, true);
  const Mask mask = rasterise(first_mesh(*session).mesh, ball_image().geometry());
  const auto inside = [&](const Eigen::Vector3d& mm) {
    const Eigen::Vector3d v = ball_image().geometry().index_from_world() * mm;
    return mask.voxels[ball_image().offset(static_cast<int>(std::lround(v[0])), static_cast<int>(std::lround(v[1])),
                                           static_cast<int>(std::lround(v[2])))] != 0;
  };
  EXPECT_FALSE(inside(too_much));
  EXPECT_TRUE(inside(too_little));
  EXPECT_TRUE(inside({-10, 0, 0}));
}

TEST(Fields, TheFieldDeterminesTheRadiusOfAPoint) {
  EvidenceField field(ball_image());
  const std::vector<Mark> seed{{MarkKind::Inside, {0, 0, 0}, 4}};
  field.update(seed);
  auto solved_field = std::make_shared<MeshField>();
  solved_field->box = field.box(), solved_field->marks = seed;
  for (const std::uint8_t voxel : field.object_in_box().voxels) solved_field->values.push_back(voxel ? 65535 : 0);
  MeshItem item;
  item.field = solved_field;
  int smaller = 0;
  for (const MarkKind kind : {MarkKind::Inside, MarkKind::Outside})
    for (double x = 0; x < 24; x += 0.5) {
      const Eigen::Vector3d at(x, 0, 0);
      const double radius = mark_radius_mm(item, kind, at, ball_image());
      EXPECT_DOUBLE_EQ(radius, field.brush_mm(kind, at)) << x;
      smaller += radius < mark_radius_mm(item, MarkKind::Boundary, at, ball_image());
    }
  EXPECT_GT(smaller, 4) << "near the surface";
}

/// A scene opened with all its points gets the same field as one in which the points were clicked.
TEST(Fields, PointsOfASceneActAsIfTheyWereClicked) {
  const auto clicked = open_with_field(), opened = open_with_field();
  const ItemId mesh = first_mesh(*clicked).id;
  clicked->advance_steps(20);
  clicked->apply(AddPoint{mesh, {17.5, 0, 0}, MarkKind::Outside});
  clicked->advance_steps(20);
  const std::vector<std::uint16_t> with_one_point = first_mesh(*clicked).field->values;
  clicked->apply(AddPoint{mesh, {0, -21, 0}, MarkKind::Inside});
  clicked->advance_steps(20);
  for (const UserPoint& p : clicked->scene().points)
    opened->apply(AddPoint{first_mesh(*opened).id, p.position_mm, p.kind, p.radius_mm, p.outward});
  opened->advance_steps(20);
  EXPECT_NE(first_mesh(*clicked).field->values, with_one_point);
  EXPECT_EQ(first_mesh(*opened).field->marks, first_mesh(*clicked).field->marks);
  EXPECT_EQ(first_mesh(*opened).field->values, first_mesh(*clicked).field->values);
}

TEST(Fields, ABoundaryPointHasAnOutwardDirection) {
  const auto session = open_with_field();
  session->advance_steps(400, true);
  const ItemId mesh = first_mesh(*session).id;
  session->apply(AddPoint{mesh, {12, 0, 0}});  // moves the surface inwards
  session->apply(AddPoint{mesh, {0, 0, 26}});  // ... and outwards
  const auto& points = session->scene().points;
  EXPECT_GT(points[0].outward.dot(Eigen::Vector3d::UnitX()), 0.9);
  EXPECT_GT(points[1].outward.dot(Eigen::Vector3d::UnitZ()), 0.9);
  session->advance_steps(1);
  EXPECT_LT(field_at(first_mesh(*session), {14, 0, 0}), 0.5);
  EXPECT_GT(field_at(first_mesh(*session), {10, 0, 0}), 0.5);
}

TEST(Fields, UndoRestoresTheField) {
  const auto session = open_with_field();
  session->advance_steps(100);
  const auto before = first_mesh(*session).field;
  session->apply(AddPoint{first_mesh(*session).id, {14, 0, 0}, MarkKind::Outside});
  session->advance_steps(10);
  const auto after = first_mesh(*session).field;
  EXPECT_NE(after, before);
  session->apply(Undo{});
  EXPECT_EQ(first_mesh(*session).field, before);
  session->advance_steps(10);
  EXPECT_EQ(first_mesh(*session).field, before) << "it fits the marks and is not solved again";
  session->apply(Redo{});
  EXPECT_EQ(first_mesh(*session).field, after);
}

TEST(Fields, AreSolvedDuringLiveFramesAndReplayGivesTheSameBits) {
  const auto live = open_with_field(2);
  const auto frames_until = [&](auto&& done) {
    // Long limit that only detects a hang: with a sanitizer and other tests running, a field takes long.
    const auto hung = std::chrono::steady_clock::now() + std::chrono::minutes(5);
    while (!done() && std::chrono::steady_clock::now() < hung) {
      live->advance(0.002);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return done();
  };
  live->advance(0.002);
  EXPECT_NE(live->solving_mesh(), 0u);
  EXPECT_EQ(live->scene().meshes[0].mesh.positions, make_sphere({1, -2, 0.5}, 12, 2).positions)
      << "a mesh waits for its first field";
  ASSERT_TRUE(frames_until([&] { return first_mesh(*live).has_field() && live->total_steps() > 50; }));
  const ItemId mesh = first_mesh(*live).id, point = live->apply(AddPoint{mesh, {14, 1, 0}, MarkKind::Outside});
  const auto first = first_mesh(*live).field;
  for (int move = 1; move <= 5; ++move) {
    live->apply(MovePoint{point, {14.0 - move, 1, 0}, true});
    live->advance(0.002);
  }
  ASSERT_TRUE(frames_until([&] {
    return first_mesh(*live).field != first && live->solving_mesh() == 0 &&
           !has_stale_field(live->scene(), first_mesh(*live), ball_image());
  }));
  frames_until([&] { return live->steps_since_last_command() > 30; });
  for (const int threads : {1, 2}) {
    const auto again = open_with_field(threads);
    again->replay(live->log(), live->steps_since_last_command());
    EXPECT_TRUE(same_bits(again->scene().meshes[0].mesh.positions, live->scene().meshes[0].mesh.positions)) << threads;
    EXPECT_EQ(first_mesh(*again).field->values, first_mesh(*live).field->values);
  }
}

TEST(Fields, TheProgressIncreasesToOneAndIsResetByTheCommit) {
  const auto session = open_with_field();
  for (int n = 0; n < 9; ++n)  // the first update applies the last eight marks one after the other
    session->apply(AddPoint{first_mesh(*session).id, {17.0 - n, 0, 0}, MarkKind::Inside, 2});
  EXPECT_EQ(session->solving_progress(), 0.0f);
  const auto hung = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  for (int solved = 0; solved < 2; ++solved) {
    session->advance(0.001);
    ASSERT_NE(session->solving_mesh(), 0u);
    float last = 0;
    while (last < 1 && std::chrono::steady_clock::now() < hung) {
      const float now = session->solving_progress();
      ASSERT_GE(now, last);
      ASSERT_LE(now, 1.0f);
      last = now;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(last, 1.0f);
    session->advance_steps(1);
    EXPECT_TRUE(first_mesh(*session).has_field());
    EXPECT_EQ(session->solving_mesh(), 0u);
    EXPECT_EQ(session->solving_progress(), 0.0f);
    session->apply(AddPoint{first_mesh(*session).id, {0, 21, 0}, MarkKind::Inside});  // for the next update
  }
}

TEST(Fields, MarksOutsideTheImageAreRefused) {
  const auto session = open_with_field();
  const ItemId mesh = first_mesh(*session).id;
  EXPECT_THROW(session->apply(AddPoint{mesh, {500, 0, 0}, MarkKind::Inside}), Error);
  const ItemId point = session->apply(AddPoint{mesh, {5, 0, 0}, MarkKind::Inside});
  EXPECT_THROW(session->apply(MovePoint{point, {500, 0, 0}}), Error);
  EXPECT_EQ(session->scene().points.back().position_mm[0], 5);
  EXPECT_THROW(session->apply(CommitFieldUpdate{}), Error) << "none is being solved";
  session->apply(AddPoint{mesh, {500, 0, 0}});  // a boundary point may lie anywhere
  EXPECT_EQ(marks_of(session->scene(), first_mesh(*session), ball_image()).size(), 2u) << "but has no mark there";
}

TEST(Fields, TheFieldOfADeletedMeshIsDiscarded) {
  const auto session = open_with_field();
  session->advance(0.001);
  ASSERT_NE(session->solving_mesh(), 0u);
  session->apply(DeleteMesh{session->scene().meshes[0].id});
  EXPECT_NO_THROW(session->advance_steps(10));
  EXPECT_EQ(session->solving_mesh(), 0u);
}

TEST(Fields, AfterACancelledFieldTheNextOneHasTheSameBits) {
  const auto plain = open_with_field(), session = open_with_field();
  plain->advance_steps(1);
  session->advance(0.001);
  ASSERT_NE(session->solving_mesh(), 0u);
  session->cancel_field_update();
  session->apply(CommitFieldUpdate{});
  EXPECT_EQ(first_mesh(*session).field, nullptr);
  session->advance_steps(1);
  ASSERT_TRUE(first_mesh(*session).has_field());
  EXPECT_EQ(first_mesh(*session).field->values, first_mesh(*plain).field->values);
}

TEST(Fields, AnUndoneMarkCancelsTheFirstField) {
  const auto session = open_with_field();
  session->apply(AddPoint{first_mesh(*session).id, {5, 0, 0}, MarkKind::Inside});
  session->advance(0.001);
  ASSERT_NE(session->solving_mesh(), 0u);
  session->apply(Undo{});
  session->apply(CommitFieldUpdate{});
  EXPECT_EQ(first_mesh(*session).field, nullptr) << "a field from the withdrawn mark";
  // An added mark does not make the field useless.
  session->advance(0.001);
  ASSERT_NE(session->solving_mesh(), 0u);
  session->apply(AddPoint{first_mesh(*session).id, {-5, 0, 0}, MarkKind::Inside});
  session->apply(CommitFieldUpdate{});
  ASSERT_TRUE(first_mesh(*session).has_field());
  EXPECT_EQ(first_mesh(*session).field->marks.size(), 1u);
}

TEST(Fields, ASessionEndsWithoutWaitingForItsField) {
  // A constant image: the object spreads through all voxels, which takes many seconds.
  VolumeGeometry geometry;
  geometry.size = {224, 224, 224};
  Volume constant(geometry, VoxelType::UInt8);
  Scene scene = ball_scene();
  set(scene.forces, {"evidence", "source", 0});
  scene.meshes[0].parameters = scene.forces;
  scene.meshes[0].seed = {geometry.centre_mm(), 20};
  scene.meshes[0].mesh = {};
  using Clock = std::chrono::steady_clock;
  Clock::time_point quit;
  {
    Session session(make_cpu_engine(1), nullptr, 1);
    session.open(std::move(scene), std::move(constant));
    session.advance(0.001);
    ASSERT_NE(session.solving_mesh(), 0u);
    while (session.solving_progress() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_LT(session.solving_progress(), 1.0f);
    quit = Clock::now();
  }
#ifdef SIMPLEXSEG_ASSERTIONS
  constexpr double limit_s = 30;  // checks and sanitizers
#else
  constexpr double limit_s = 3;  // usually some milliseconds; other programs can take the processor
#endif
  EXPECT_LT(std::chrono::duration<double>(Clock::now() - quit).count(), limit_s);
}

}  // namespace
}  // namespace simplexseg
