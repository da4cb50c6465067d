// SPDX-License-Identifier: Apache-2.0
// Strokes and boxes in a session: marks, undo and replay.
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "field/evidence_field.h"
#include "forces/force_list.h"
#include "session/lasso.h"
#include "session/mesh_marks.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

AddPoint outside_stroke(ItemId mesh) {
  return {mesh, {15, -6, 0}, MarkKind::Outside, 0, {0, 0, 0}, {{1, 6, 0}, {0, 12, 0}}};
}

TEST(Strokes, AreMarksAlongTheirPathAndMoveAsAWhole) {
  const auto session = open_with_field();
  session->advance_steps(300, true);
  const ItemId mesh = first_mesh(*session).id, stroke = session->apply(outside_stroke(mesh));
  const UserPoint& point = *session->scene().find_point(stroke);
  EXPECT_TRUE(point.is_stroke());
  EXPECT_GT(point.radius_mm, 0);
  std::vector<Mark> marks = marks_of(session->scene(), first_mesh(*session), ball_image());
  ASSERT_GT(marks.size(), 5u);
  EXPECT_EQ(marks[1].position_mm, Eigen::Vector3d(15, -6, 0));
  EXPECT_LT((marks.back().position_mm - Eigen::Vector3d(15, 6, 0)).norm(), 1e-9);
  session->apply(MovePoint{stroke, {15, -6, 2}});
  marks = marks_of(session->scene(), first_mesh(*session), ball_image());
  EXPECT_LT((marks.back().position_mm - Eigen::Vector3d(15, 6, 2)).norm(), 1e-9);
  session->apply(DeletePoint{stroke});
  EXPECT_EQ(marks_of(session->scene(), first_mesh(*session), ball_image()).size(), 1u);
}

TEST(Strokes, ChangeTheFieldInOneUpdateAndUndoRestoresIt) {
  const auto session = open_with_field();
  session->advance_steps(300, true);
  const auto before = first_mesh(*session).field;
  session->apply(outside_stroke(first_mesh(*session).id));
  session->advance_steps(1);
  int updates = 0;
  for (const LogEntry& entry : session->log()) updates += std::holds_alternative<CommitFieldUpdate>(entry.command);
  EXPECT_EQ(updates, 2) << "the seed, and the stroke";
  EXPECT_NE(first_mesh(*session).field, before);
  session->apply(Undo{});
  EXPECT_EQ(first_mesh(*session).field, before);
  EXPECT_TRUE(session->scene().points.empty());
}

TEST(Strokes, OfASceneActAsIfTheyWereDrawn) {
  const auto drawn = open_with_field(), opened = open_with_field();
  drawn->advance_steps(1);
  for (const double z : {0.0, 5.0}) {
    AddPoint stroke = outside_stroke(first_mesh(*drawn).id);
    stroke.position_mm.z() = z;
    drawn->apply(stroke);
    drawn->advance_steps(1);
  }
  for (const UserPoint& p : drawn->scene().points)
    opened->apply(AddPoint{first_mesh(*opened).id, p.position_mm, p.kind, p.radius_mm, p.outward, p.path_mm});
  opened->advance_steps(1);
  EXPECT_EQ(first_mesh(*opened).field->values, first_mesh(*drawn).field->values);
}

TEST(Strokes, ReplayToTheSameBits) {
  const auto live = open_with_field();
  live->advance_steps(200);
  const ItemId stroke = live->apply(outside_stroke(first_mesh(*live).id));
  live->advance_steps(50);
  live->apply(MovePoint{stroke, {15, -6, 1}});
  live->advance_steps(50);
  const auto replayed = open_with_field();
  replayed->replay(live->log(), live->steps_since_last_command());
  EXPECT_EQ(first_mesh(*replayed).mesh.positions, first_mesh(*live).mesh.positions);
}

TEST(Strokes, InvalidPathsAreRefused) {
  const auto session = open_with_field();
  const ItemId mesh = first_mesh(*session).id;
  AddPoint stroke = outside_stroke(mesh);
  stroke.kind = MarkKind::Boundary;
  EXPECT_THROW(session->apply(stroke), Error);
  stroke = outside_stroke(mesh);
  stroke.path_mm.emplace_back(NAN, 0, 0);
  EXPECT_THROW(session->apply(stroke), Error);
  stroke.path_mm.assign(10'001, {1, 0, 0});
  EXPECT_THROW(session->apply(stroke), Error);
  stroke.path_mm = {{1e8, 0, 0}};
  EXPECT_NE(refusal(*session, stroke).find("2000"), std::string::npos);
  stroke.path_mm = {{10, 0, 0}}, stroke.radius_mm = 1e-10;
  EXPECT_NE(refusal(*session, stroke).find("2000"), std::string::npos);
  stroke.radius_mm = 0;
  EXPECT_TRUE(session->scene().points.empty());
  // Parts of a path outside the image are not marks.
  stroke.path_mm = {{500, 0, 0}};
  session->apply(stroke);
  for (const Mark& mark : marks_of(session->scene(), first_mesh(*session), ball_image()))
    EXPECT_TRUE(ball_image().geometry().contains(mark.position_mm));
}

AddMesh start_of_box() {
  AddMesh command;
  command.name = "boxed";
  command.box_mm = {{-21, -9, 0}, {21, -9, 0}, {21, 9, 0}, {-21, 9, 0}};
  return command;
}

TEST(Boxes, StartAMeshWithStrokesInOneCommandAndOneUpdate) {
  const auto session = open_with_field();
  session->apply(DeleteMesh{first_mesh(*session).id});
  const ItemId mesh = session->apply(start_of_box());
  EXPECT_EQ(session->scene().find_mesh(mesh)->seed.centre_mm, Eigen::Vector3d(0, 0, 0));
  ASSERT_EQ(session->scene().points.size(), 2u);
  EXPECT_EQ(session->scene().points[0].kind, MarkKind::Inside);
  EXPECT_EQ(session->scene().points[1].kind, MarkKind::Outside);
  session->advance_steps(1);
  EvidenceField once(ball_image(), run_serially());
  once.update(marks_of(session->scene(), first_mesh(*session), ball_image()));
  EXPECT_EQ(first_mesh(*session).field->object_cells(), once.object_in_box().voxels);
  session->apply(Undo{});
  EXPECT_TRUE(session->scene().meshes.empty());
  EXPECT_TRUE(session->scene().points.empty());
  session->apply(Redo{});
  EXPECT_EQ(session->scene().points.size(), 2u);
}

TEST(Boxes, InvalidOnesAreRefused) {
  const auto session = open_with_field();
  AddMesh command = start_of_box();
  command.box_mm.pop_back();
  EXPECT_NE(refusal(*session, command).find("four corners"), std::string::npos);
  command = start_of_box();
  for (Eigen::Vector3d& corner : command.box_mm) corner.x() += 500;
  EXPECT_NE(refusal(*session, command).find("outside the image"), std::string::npos);
}

TEST(Lasso, BringsTheSurfaceToItInOneUpdate) {
  const auto session = open_with_field();
  session->advance_steps(300, true);
  const ItemId mesh = first_mesh(*session).id;
  // A circle of 16 mm in the ball of 20 mm: the border of the object in this slice.
  std::vector<Eigen::Vector3d> circle;
  for (int n = 0; n < 60; ++n)
    circle.emplace_back(16 * std::cos(n * std::numbers::pi / 30), 16 * std::sin(n * std::numbers::pi / 30), 0);
  const auto farthest_in_slice = [&] {
    double farthest = 0;
    for (const Eigen::Vector3f& p : first_mesh(*session).mesh.positions)
      if (std::abs(p.z()) < 1) farthest = std::max<double>(farthest, p.norm());
    return farthest;
  };
  ASSERT_GT(farthest_in_slice(), 19);
  const std::size_t before = session->history().undo_names().size();
  session->apply(AddLasso{mesh, MarkKind::Inside, circle, {0, 0, 1}});
  EXPECT_EQ(session->history().undo_names().size(), before + 1) << "one action";
  ASSERT_EQ(session->scene().points.size(), 1u) << "one item";
  EXPECT_GE(stroke_count(session->scene().points[0]), 3);
  const auto field = first_mesh(*session).field;
  session->advance_steps(800, true);
  EXPECT_NE(first_mesh(*session).field, field);
  EXPECT_LT(farthest_in_slice(), 18);
  session->apply(Undo{});
  EXPECT_TRUE(session->scene().points.empty());
  EXPECT_NE(refusal(*session, AddLasso{mesh, MarkKind::Inside, {{0, 0, 0}, {1, 0, 0}}, {0, 0, 1}}).find("three"),
            std::string::npos);
  EXPECT_NE(refusal(*session, AddLasso{mesh, MarkKind::Inside, circle, {0, 0, 2}}).find("unit"), std::string::npos);
}

std::vector<Eigen::Vector3d> circle_of(double radius_mm, const Eigen::Vector3d& centre_mm = {0, 0, 0}) {
  std::vector<Eigen::Vector3d> circle;
  for (int n = 0; n < 60; ++n)
    circle.emplace_back(centre_mm + radius_mm * Eigen::Vector3d(std::cos(n * std::numbers::pi / 30),
                                                                std::sin(n * std::numbers::pi / 30), 0));
  return circle;
}

TEST(Lasso, IsMovedAndDeletedAsOneItem) {
  const auto session = open_with_field();
  const ItemId mesh = first_mesh(*session).id;
  const ItemId lasso = session->apply(AddLasso{mesh, MarkKind::Inside, circle_of(12), {0, 0, 1}});
  const std::vector<Mark> before = marks_of(session->scene(), first_mesh(*session), ball_image());
  const UserPoint* point = session->scene().find_point(lasso);
  ASSERT_NE(point, nullptr);
  const Eigen::Vector3d start = point->position_mm, by(2, -1, 3);
  session->apply(MovePoint{lasso, start + by});
  const std::vector<Mark> after = marks_of(session->scene(), first_mesh(*session), ball_image());
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t m = 1; m < after.size(); ++m) {
    EXPECT_LT((after[m].position_mm - before[m].position_mm - by).norm(), 1e-6);
    EXPECT_EQ(after[m].link, before[m].link);
  }
  EXPECT_NE(refusal(*session, MovePoint{lasso, {500, 0, 0}}).find("encloses nothing"), std::string::npos);
  EXPECT_NE(refusal(*session, ResizePoint{lasso, 3}).find("no radius"), std::string::npos);
  session->apply(Undo{});
  EXPECT_EQ(marks_of(session->scene(), first_mesh(*session), ball_image()), before);
  session->apply(DeletePoint{lasso});
  EXPECT_EQ(marks_of(session->scene(), first_mesh(*session), ball_image()).size(), 1u);
  EXPECT_EQ(session->history().undo_names().back(), "delete inside lasso: ball");
  session->apply(Undo{});
  EXPECT_EQ(marks_of(session->scene(), first_mesh(*session), ball_image()), before);
}

TEST(Lasso, TakesTheIdsOfItsStrokesSoThatOldLogsCanBeReplayed) {
  const auto session = open_with_field();
  const ItemId mesh = first_mesh(*session).id;
  const ItemId lasso = session->apply(AddLasso{mesh, MarkKind::Inside, circle_of(12), {0, 0, 1}});
  const int strokes = stroke_count(*session->scene().find_point(lasso));
  EXPECT_EQ(session->apply(AddPoint{mesh, {0, 0, 5}, MarkKind::Inside}), lasso + static_cast<ItemId>(strokes));
}

TEST(Lasso, StartsAMeshInOneCommandAndOneUpdate) {
  const auto session = open_with_field();
  session->apply(DeleteMesh{first_mesh(*session).id});
  AddMesh start;
  start.contour_mm = circle_of(20);
  const ItemId mesh = session->apply(start);
  const MeshItem& item = *session->scene().find_mesh(mesh);
  EXPECT_LT(item.seed.centre_mm.norm(), 0.5);
  ASSERT_EQ(session->scene().points.size(), 1u);
  EXPECT_TRUE(session->scene().points[0].is_lasso());
  EXPECT_TRUE(session->scene().points[0].continues) << "in the same update as the seed";
  const std::vector<Mark> marks = marks_of(session->scene(), item, ball_image());
  for (std::size_t m = 1; m < marks.size(); ++m) EXPECT_NE(marks[m].link, MarkLink::None) << "one update";
  session->apply(Undo{});
  EXPECT_TRUE(session->scene().meshes.empty() && session->scene().points.empty());
  session->apply(Redo{});
  EXPECT_EQ(session->scene().points.size(), 1u);
  start.box_mm = start_of_box().box_mm;
  start.name = "both";
  EXPECT_NE(refusal(*session, start).find("a box and a lasso"), std::string::npos);
  start.box_mm.clear();
  start.contour_mm = circle_of(20, {500, 0, 0});
  EXPECT_NE(refusal(*session, start).find("encloses nothing"), std::string::npos);
  start.contour_mm.resize(2);
  EXPECT_NE(refusal(*session, start).find("three"), std::string::npos);
}

}  // namespace
}  // namespace simplexseg
