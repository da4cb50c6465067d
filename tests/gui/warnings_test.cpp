// SPDX-License-Identifier: Apache-2.0
// Messages about undone steps and self-intersecting surfaces.
#include <QLabel>

#include "gui/panels/simulation_panel.h"
#include "gui/workbench/repeated_warning.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class WarningsTest : public WindowTest {};

TEST_F(WarningsTest, ManyLinesBecomeOneMessageAtATime) {
  RepeatedWarning warning(50);
  QStringList messages;
  QObject::connect(&warning, &RepeatedWarning::message, [&](const QString& text) { messages << text; });
  warning.add({});
  EXPECT_TRUE(messages.isEmpty());
  warning.add({"mesh 'a': the first"});
  EXPECT_EQ(messages, QStringList{"mesh 'a': the first"});  // at once
  for (int n = 0; n < 9; ++n) warning.add({"mesh 'a': another", "mesh 'b': the last"});
  EXPECT_EQ(messages.size(), 1);
  ASSERT_TRUE(wait_until([&] { return messages.size() > 1; }));
  EXPECT_EQ(messages[1], "mesh 'b': the last (and 17 more)");
}

TEST_F(WarningsTest, ASelfIntersectingSurfaceIsReported) {
  open_phantom();
  const QLabel* surface = window_->panels().simulation().surface();
  const QLabel* motion = window_->panels().simulation().motion();
  EXPECT_EQ(surface->text(), "not run yet");
  Scene folded = scene();
  const Volume volume = bench().session().volume();
  MeshItem& item = folded.meshes[0];
  item.parameters.values[static_cast<int>(ForceId::Smoothing)][0] = 0;  // no force moves it
  folded.simulation.final_vertices = static_cast<float>(item.mesh.vertex_count());
  bench().open(folded, volume);
  bench().advance_steps(10, true);
  bench().run();
  ASSERT_TRUE(wait_until([&] { return motion->text().contains("settled"); })) << motion->text().toStdString();
  EXPECT_EQ(surface->text(), "no self-overlap");
  EXPECT_FALSE(motion->text().contains("overlaps"));

  // One vertex through to the other side.
  item.mesh.positions[0] = 2 * item.seed.centre_mm.cast<float>() - item.mesh.positions[0];
  item.previous = item.mesh.positions;
  bench().open(folded, volume);
  bench().run();
  ASSERT_TRUE(wait_until([&] { return motion->text().contains("overlaps itself"); })) << motion->text().toStdString();
  EXPECT_TRUE(surface->text().startsWith("the surface overlaps itself in ")) << surface->text().toStdString();
  EXPECT_EQ(surface->property("role"), "warning");
  EXPECT_NE(motion->property("role"), "warning");
}

}  // namespace
}  // namespace simplexseg
