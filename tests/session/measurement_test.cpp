// SPDX-License-Identifier: Apache-2.0
// Measurements in a session: undo, replay, refusal, and the table.
#include <algorithm>

#include "mesh/mesh_geometry.h"
#include "session/measurement_csv.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

AddMeasurement ruler() { return {MeasurementKind::Ruler, {{0, 0, 0}, {3, 4, 0}}, ""}; }

TEST(Measurements, HaveTheFirstFreeNameOfTheirKind) {
  const auto session = open_session();
  session->apply(ruler());
  const ItemId second = session->apply(ruler());
  session->apply(AddMeasurement{MeasurementKind::Angle, {{1, 0, 0}, {0, 0, 0}, {0, 1, 0}}, ""});
  const auto& measurements = session->scene().measurements;
  ASSERT_EQ(measurements.size(), 3u);
  EXPECT_EQ(measurements[1].name, "ruler 2");
  EXPECT_EQ(measurements[2].name, "angle 1");
  session->apply(RenameMeasurement{second, "width"});
  EXPECT_EQ(session->scene().find_measurement(session->apply(ruler()))->name, "ruler 2");
}

TEST(Measurements, ADragIsUndoneTogether) {
  const auto session = open_session();
  const ItemId id = session->apply(ruler());
  const SessionState before = state_of(*session);
  for (int k = 1; k <= 4; ++k) session->apply(MoveMeasurement{id, {{0, 0, 0}, {3.0 + k, 4, 0}}, k > 1});
  EXPECT_EQ(session->scene().find_measurement(id)->points_mm[1].x(), 7);
  EXPECT_EQ(session->history().undo_names().size(), 2u);
  EXPECT_EQ(session->history().undo_names().back(), "move measurement: ruler 1");
  session->apply(Undo{});
  EXPECT_TRUE(same_state(state_of(*session), before));
  session->apply(Redo{});
  EXPECT_EQ(session->scene().find_measurement(id)->points_mm[1].x(), 7);
}

TEST(Measurements, AReplayRestoresThem) {
  const auto live = open_session(), replayed = open_session();
  live->advance_steps(5);
  const ItemId id = live->apply(ruler());
  live->advance_steps(5);
  for (int k = 1; k <= 3; ++k) live->apply(MoveMeasurement{id, {{0, 0, 0}, {1.0 / k, 4, 0}}, k > 1});
  live->apply(AddMeasurement{MeasurementKind::Ellipse, {{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}, "roi"});
  live->apply(DeleteMeasurement{id});
  live->apply(Undo{});
  live->advance_steps(10);
  replayed->replay(live->log(), live->steps_since_last_command());
  EXPECT_EQ(replayed->scene().measurements.size(), 2u);
  EXPECT_TRUE(same_state(state_of(*replayed), state_of(*live)));
}

TEST(Measurements, DoNotAffectTheSimulation) {
  const auto measured = open_session(), plain = open_session();
  measured->advance_steps(5);
  const ItemId id = measured->apply(ruler());
  measured->advance_steps(5);
  measured->apply(MoveMeasurement{id, {{0, 0, 0}, {1, 4, 0}}});
  measured->apply(RenameMeasurement{id, "width"});
  measured->apply(DeleteMeasurement{id});
  measured->advance_steps(10);
  plain->advance_steps(20);
  EXPECT_EQ(first_mesh(*measured).mesh.positions, first_mesh(*plain).mesh.positions);
}

TEST(Measurements, InvalidOnesAreRefused) {
  const auto session = open_session();
  const ItemId id = session->apply(ruler());
  refusal(*session, AddMeasurement{MeasurementKind::Angle, {{0, 0, 0}, {1, 0, 0}}, ""});
  refusal(*session, AddMeasurement{MeasurementKind::Ellipse, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}, ""});
  refusal(*session, MoveMeasurement{id, {{1, 1, 1}, {1, 1, 1}}});
  session->apply(MoveMeasurement{id, {{1, 1, 1}, {2, 1, 1}}});
  refusal(*session, MoveMeasurement{id, {{1, 1, 1}}, true});
  refusal(*session, MoveMeasurement{id + 50, {{1, 1, 1}, {2, 1, 1}}});
  refusal(*session, RenameMeasurement{id, ""});
  refusal(*session, DeleteMeasurement{first_mesh(*session).id});
}

TEST(Measurements, AreATableWithALineForEach) {
  const auto session = open_session();
  session->apply(AddMeasurement{MeasurementKind::Ruler, {{0, 0, 0}, {3, 4, 0}}, "a, \"b\""});
  session->apply(AddMeasurement{MeasurementKind::Angle, {{1, 0, 0}, {0, 0, 0}, {0, 1, 0}}, ""});
  session->apply(AddMeasurement{MeasurementKind::Ellipse, {{0, 0, 0}, {5, 0, 0}, {0, 5, 0}}, ""});
  session->apply(AddMeasurement{MeasurementKind::Ellipse, {{900, 0, 0}, {905, 0, 0}, {900, 5, 0}}, "outside"});
  const std::string table = measurement_csv(session->scene(), session->volume());
  EXPECT_TRUE(
      table.starts_with("name,kind,length_mm,angle_degrees,area_mm2,mean,deviation,minimum,maximum,voxels,"
                        "volume_mm3,long_axis_mm,short_axis_mm,slice,points_mm\n\"a, \"\"b\"\"\",ruler,5,,,,,,,,"
                        ",,,,0 0 0; 3 4 0\nangle 1,angle,,90,,,,,,,,,,,1 0 0; 0 0 0; 0 1 0\n"))
      << table;
  EXPECT_NE(table.find("\noutside,ellipse,,,78.53982,,,,,,,,,,900 0 0"), std::string::npos) << table;
  const std::string ball = table.substr(table.find("\nball,segmentation"));
  // Long and short axis of the ball, in a table with the same number of fields.
  EXPECT_EQ(std::count(ball.begin(), ball.end(), ','), 14);
  EXPECT_NE(measurement_csv(session->scene(), Volume()).find("ball,segmentation,,,,,,,,,"), std::string::npos);
}

}  // namespace
}  // namespace simplexseg
