// SPDX-License-Identifier: Apache-2.0
// Simulation steps in another thread while an image is drawn; on the CPU only when enabled.
#include <QElapsedTimer>
#include <QLabel>
#include <QSignalSpy>
#include <QTest>

#include "gpu/backend.h"
#include "gui/workbench/frame_loop.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class ConcurrentStepsTest : public PausedPhantomTest {
 protected:
  FrameLoop& loop() { return window_->loop(); }
  void set_rest_tolerance(float voxels) {
    bench().apply(SetSimulationParameter{find_parameter(simulation_table(), "rest_tolerance"), voxels});
  }
};

TEST_F(ConcurrentStepsTest, OnTheCpuStepsRunConcurrentlyOnlyWhenEnabled) {
  set_rest_tolerance(0);
  QSignalSpy finished(&bench(), &Workbench::advance_finished);
  bench().run();
  EXPECT_TRUE(wait_until([&] { return bench().session().total_steps() > 50; }));
  EXPECT_EQ(finished.count(), 0);
  loop().set_concurrent(true);
  EXPECT_TRUE(wait_until([&] { return finished.count() > 5; }));
  loop().set_concurrent(false);
  EXPECT_TRUE(wait_until([&] { return !bench().is_advancing(); }));
  const auto before = finished.count();
  const std::int64_t steps = bench().session().total_steps();
  EXPECT_TRUE(wait_until([&] { return bench().session().total_steps() > steps + 50; }));
  EXPECT_EQ(finished.count(), before);
}

TEST_F(ConcurrentStepsTest, NumbersFollowADragWhenItPauses) {
  set_rest_tolerance(0);
  const ItemId mesh = scene().meshes[0].id;
  const Eigen::Vector3d place = scene().meshes[0].seed.centre_mm + Eigen::Vector3d(15, 0, 0);
  ItemId point = 0;
  bench().apply(AddPoint{mesh, place}, &point);
  bench().run();
  const auto numbers = [&] {
    QStringList texts;
    for (const QLabel* label : window_->findChildren<QLabel*>()) texts << label->text();
    return texts;
  };
  QSignalSpy paused(&bench(), &Workbench::scene_changed);
  int moves = 0;
  const auto drag_for_ms = [&](int ms) {
    QElapsedTimer since;
    since.start();
    while (since.elapsed() < ms) {
      bench().apply(MovePoint{point, place + Eigen::Vector3d(0.01 * ++moves, 0, 0), moves > 1});
      QTest::qWait(5);
    }
  };
  bool unchanged = false, always_paused = true;
  for (int attempt = 0; attempt < 6 && !unchanged; ++attempt) {
    drag_for_ms(400);  // earlier changes are painted
    const qsizetype pauses = paused.count();
    const QStringList before = numbers();
    const std::int64_t steps = bench().session().total_steps();
    drag_for_ms(600);
    if (paused.count() != pauses) continue;  // the machine was busy, and the drag paused
    always_paused = false;
    unchanged = numbers() == before && bench().session().total_steps() > steps + 10;
  }
  if (always_paused) GTEST_SKIP() << "here a frame takes longer than the drag pause";
  EXPECT_TRUE(unchanged);
  const QStringList before = numbers();
  EXPECT_TRUE(wait_until([&] { return numbers() != before; }));
}

TEST_F(ConcurrentStepsTest, ReplayOfTheLogGivesTheSameBits) {
  const Scene start = scene();
  const ItemId mesh = start.meshes[0].id;
  const Eigen::Vector3d centre = start.meshes[0].seed.centre_mm;
  loop().set_concurrent(true);
  QSignalSpy finished(&bench(), &Workbench::advance_finished), advanced(&bench(), &Workbench::advanced);
  set_rest_tolerance(0);
  bench().run();
  ItemId point = 0;
  int last = 0;
  const auto wait_for_images = [&] {
    EXPECT_TRUE(wait_until([&] { return finished.count() > last + 2; }));
    last = static_cast<int>(finished.count());
  };
  wait_for_images();
  bench().apply(AddPoint{mesh, centre + Eigen::Vector3d(15, 0, 0)}, &point);
  for (int n = 0; n < 6; ++n) {
    wait_for_images();
    bench().apply(MovePoint{point, centre + Eigen::Vector3d(15, 0.8 * n, 0), n > 0});
  }
  wait_for_images();
  bench().apply(Undo{});
  bench().run();
  wait_for_images();
  bench().apply(RefineMesh{mesh});
  wait_for_images();
  bench().apply(SetForceParameter{mesh, ForceId::Smoothing, 0, 0.2f});
  wait_for_images();
  bench().pause();
  EXPECT_TRUE(wait_until([&] { return !bench().is_advancing(); }));
  const Session& done = bench().session();
  const std::vector<Eigen::Vector3f> positions = done.scene().meshes[0].mesh.positions;
  std::int64_t reported_steps = 0;
  for (const auto& one : advanced) reported_steps += one[0].value<Advance>().steps;
  EXPECT_EQ(reported_steps, done.total_steps());  // each batch is reported once

  Session again(make_cpu_engine(1));
  again.open(start, done.volume());
  again.replay(done.log(), done.steps_since_last_command());
  EXPECT_EQ(again.total_steps(), done.total_steps());
  EXPECT_EQ(again.scene().meshes[0].mesh.positions, positions);
}

TEST_F(ConcurrentStepsTest, AccessToTheSessionStopsTheSteps) {
  set_rest_tolerance(0);
  const std::int64_t before = bench().session().total_steps();
  bench().begin_advance(3600);
  QTest::qSleep(30);
  const std::int64_t steps = bench().session().total_steps();
  EXPECT_GT(steps, before);
  QTest::qSleep(30);
  EXPECT_EQ(bench().session().total_steps(), steps);
  EXPECT_EQ(bench().end_advance().steps, steps - before);
  EXPECT_FALSE(bench().is_advancing());
}

TEST_F(ConcurrentStepsTest, ActionsAfterTheLastStepsPreventSettling) {
  set_rest_tolerance(0);
  bench().apply(SetSimulationParameter{find_parameter(simulation_table(), "frame_budget"), 200});
  bench().run();
  loop().tick();
  ASSERT_TRUE(loop().active());
  loop().set_concurrent(true);
  set_rest_tolerance(1);
  QSignalSpy finished(&bench(), &Workbench::advance_finished);
  loop().view_composing();
  ASSERT_TRUE(bench().is_advancing());
  QTest::qSleep(250);  // it settles meanwhile
  ASSERT_TRUE(bench().advance_result().at_rest);
  const MeshItem& item = scene().meshes[0];
  bench().apply(AddPoint{item.id, item.seed.centre_mm + Eigen::Vector3d(15, 0, 0)});
  loop().tick();
  EXPECT_FALSE(loop().settled());
  EXPECT_TRUE(loop().active());
  const std::int64_t steps = bench().session().total_steps();
  EXPECT_TRUE(wait_until([&] { return bench().session().total_steps() > steps; }));
}

TEST_F(ConcurrentStepsTest, AMovedPointIsShownBeforeFurtherSteps) {
  set_rest_tolerance(0);
  ItemId point = 0;
  const Eigen::Vector3d place = scene().meshes[0].seed.centre_mm + Eigen::Vector3d(15, 0, 0);
  bench().apply(AddPoint{scene().meshes[0].id, place}, &point);
  bench().run();
  loop().set_concurrent(true);
  loop().tick();
  bench().apply(MovePoint{point, place + Eigen::Vector3d(1, 0, 0)});
  loop().view_about_to_paint();
  loop().view_composing();
  EXPECT_FALSE(bench().is_advancing());
  loop().view_shown();
  ASSERT_TRUE(bench().is_advancing());
  EXPECT_GT(bench().advance_result().steps, 0);
  // The next image shows no moved point: steps run concurrently again.
  loop().tick();
  loop().view_about_to_paint();
  loop().view_composing();
  EXPECT_TRUE(bench().is_advancing());
}

TEST_F(ConcurrentStepsTest, AClosingWindowWaitsForTheSteps) {
  set_rest_tolerance(0);
  bench().run();
  bench().begin_advance(3600);
  window_.reset();
}

}  // namespace
}  // namespace simplexseg
