// SPDX-License-Identifier: Apache-2.0
// End of the program, and of a segmentation, while its field is being solved.
#include <QElapsedTimer>
#include <chrono>
#include <thread>

#include "forces/evidence.h"
#include "gui/workbench/frame_loop.h"
#include "gui/workbench/run_state.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

constexpr qint64 kLimitMs = 3000;  ///< usually below one second; other tests can take the processor

class QuitTest : public WindowTest {
 protected:
  /// Starts the field of a segmentation in a constant image of 224^3 voxels. The object spreads through all voxels,
  /// which takes many seconds.
  void start_long_field() {
    VolumeGeometry geometry;
    geometry.size = {224, 224, 224};
    Scene scene;
    scene.simulation = default_simulation_parameters();
    MeshItem item;
    item.name = "object";
    item.seed = {geometry.centre_mm(), 20};
    item.parameters = default_force_parameters();
    item.parameters.values[static_cast<int>(ForceId::Evidence)][0] = 1;
    item.parameters.values[static_cast<int>(ForceId::Evidence)][EvidenceForce::source] = 0;
    scene.meshes.push_back(item);
    bench().open(std::move(scene), Volume(geometry, VoxelType::UInt8));
    bench().run();
    ASSERT_TRUE(wait_until([this] { return bench().solving_percent() > 0; }));
    ASSERT_LT(bench().solving_percent(), 100);
  }
};

TEST_F(QuitTest, TheWindowClosesWithinASecondWhileAFieldIsSolved) {
  start_long_field();
  QElapsedTimer timer;
  timer.start();
  window_->actions()[Act::Quit]->trigger();
  EXPECT_FALSE(window_->isVisible());
  window_.reset();  // as at the end of the program
  EXPECT_LT(timer.elapsed(), kLimitMs);
}

TEST_F(QuitTest, TheWindowClosesWithinASecondWhileAMeshIsComparedWithItsField) {
  open_phantom();
  Scene start = scene();
  start.meshes[0].parameters = default_force_parameters();
  const Volume volume = bench().session().volume();
  bench().open(std::move(start), volume);
  // Holds the comparison until it is stopped.
  bench().draw([](Session& session) {
    session.set_field_comparison([](const MeshItem&, bool, const SimulationParameters&, const Volume&,
                                    const StopCheck& check_stop) -> FieldComparison {
      for (;; std::this_thread::sleep_for(std::chrono::milliseconds(1))) check_stop();
    });
  });
  bench().run();
  const ItemId mesh = scene().meshes[0].id;
  ASSERT_TRUE(wait_until([&] { return bench().session().is_comparing(mesh); }));
  const std::int64_t steps = bench().session().total_steps();
  ASSERT_TRUE(wait_until([&] { return bench().session().total_steps() > steps + 200; }));
  EXPECT_TRUE(bench().session().is_comparing(mesh)) << "no frame waits for the comparison";
  EXPECT_FALSE(window_->loop().settled());
  EXPECT_EQ(mesh_state(bench(), window_->loop(), 0), RunState::Running);
  QElapsedTimer timer;
  timer.start();
  window_->actions()[Act::Quit]->trigger();
  EXPECT_FALSE(window_->isVisible());
  window_.reset();
  EXPECT_LT(timer.elapsed(), kLimitMs);
}

TEST_F(QuitTest, ADeletedSegmentationIsNotSolvedToTheEnd) {
  start_long_field();
  QElapsedTimer timer;
  timer.start();
  bench().apply(DeleteMesh{scene().meshes[0].id});
  EXPECT_EQ(bench().session().solving_mesh(), 0u);
  EXPECT_LT(timer.elapsed(), kLimitMs);
}

TEST_F(QuitTest, AnUndoneSegmentationIsNotSolvedToTheEnd) {
  start_long_field();
  const Seed other{scene().meshes[0].seed.centre_mm + Eigen::Vector3d(40, 0, 0), 10};
  bench().apply(DeleteMesh{scene().meshes[0].id});
  bench().apply(AddMesh{"other", other, {}, 0});
  ASSERT_TRUE(wait_until([this] { return bench().solving_percent() > 0; }));
  QElapsedTimer timer;
  timer.start();
  bench().apply(Undo{});
  EXPECT_TRUE(scene().meshes.empty());
  EXPECT_EQ(bench().session().solving_mesh(), 0u);
  EXPECT_LT(timer.elapsed(), kLimitMs);
}

TEST_F(QuitTest, AnotherImageOpensWithoutWaitingForTheField) {
  start_long_field();
  QElapsedTimer timer;
  timer.start();
  open_phantom();
  EXPECT_LT(timer.elapsed(), kLimitMs);
}

}  // namespace
}  // namespace simplexseg
