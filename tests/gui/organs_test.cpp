// SPDX-License-Identifier: Apache-2.0
// What the window is for: four organs of a CT with the settings that every new mesh has, a seed and at most six points
// for each, by mouse and keys alone. What is reached: docs/results/evidence-2026-11-23-second.md.
#include <QAction>
#include <QApplication>
#include <QElapsedTimer>
#include <QKeyEvent>

#include "core/error.h"
#include "evidence/robot_user.h"
#include "gui/window/message_bar.h"
#include "gui/window/state_chip.h"
#include "image/rasterise.h"
#include "io/data_path.h"
#include "io/volume_io.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

constexpr int kMostPoints = 6;

std::optional<Volume> volume_of(const char* name) {
  try {
    return read_volume(find_data(name, std::filesystem::path(SIMPLEXSEG_SOURCE_DIR) / "../shared/data"));
  } catch (const Error&) {
    return std::nullopt;
  }
}

struct Organ {
  const char* name;
  double label;
  double dice;   ///< the robot stops there, as a user would
  double least;  ///< to be reached before the points are used up
  Mask truth{};
  ItemId mesh = 0;
  int points = 0;
  double reached = 0;  ///< largest Dice at rest: whoever goes on from there can take it back
};

class OrgansTest : public WindowTest {
 protected:
  void press_key(int key) {
    QKeyEvent event(QEvent::KeyPress, key, Qt::NoModifier);
    QApplication::sendEvent(&axial(), &event);
  }
  /// Turns the wheel over the axial view until it shows the slice of that place; there, in pixels.
  QPointF show(const Eigen::Vector3d& mm) {
    const auto away = [&] { return std::fabs(axial().distance_to_slice_mm(mm)); };
    const double slice_mm = bench().session().volume().geometry().spacing_mm.z();
    const QPointF corner(30, 30);
    for (int notches = 0; away() > 0.6 * slice_mm && notches < 1000; ++notches) {
      const double before = away();
      wheel(axial(), corner, 1);
      if (away() > before) wheel(axial(), corner, -2);
    }
    return axial().pixel_of(mm);
  }
  /// Until nothing moves and nothing is learned.
  bool wait_for_rest() {
    constexpr int most_ms = 120000, still_ms = 300;
    QElapsedTimer all, still;
    all.start();
    bool at_rest = false;
    const auto follows = QObject::connect(&bench(), &Workbench::advanced, [&](const Advance& done) {
      if (done.at_rest && !at_rest) still.start();
      at_rest = done.at_rest;
    });
    const auto rests = [&] { return at_rest && bench().session().learning() == 0 && still.elapsed() > still_ms; };
    while (!rests() && all.elapsed() < most_ms) QApplication::processEvents(QEventLoop::AllEvents, 20);
    QObject::disconnect(follows);
    return rests();
  }
  Mask now(const Organ& organ) {
    return rasterise(bench().session().scene().find_mesh(organ.mesh)->mesh, organ.truth.geometry);
  }
};

TEST_F(OrgansTest, FourOrgansByASeedAndSixPointsEach) {
  const std::optional<Volume> image = volume_of("ct_abdomen/ct.nii.gz"), labels = volume_of("ct_abdomen/labels.nii.gz");
  if (!image || !labels) GTEST_SKIP() << "the CT of the abdomen is not on this machine";
  Scene empty;
  empty.simulation = default_simulation_parameters();
  bench().open(std::move(empty), *image);
  QApplication::processEvents();
  const Eigen::Affine3d world = image->geometry().world_from_index();
  const auto place = [&](const std::array<int, 3>& voxel) -> Eigen::Vector3d {
    return world * Eigen::Vector3d(voxel[0], voxel[1], voxel[2]);
  };
  std::vector<Organ> organs{{"left kidney", 3, 0.90, 0.88},
                            {"right kidney", 2, 0.90, 0.88},
                            {"bladder", 21, 0.92, 0.92},
                            {"L3", 29, 0.85, 0.85}};
  for (Organ& organ : organs) {
    organ.truth = mask_of(*labels, organ.label);
    organ.truth.geometry = image->geometry();
    organ.truth = largest_part(organ.truth);
    const WorstError deepest = *deepest_voxel(organ.truth);
    const QPointF middle = show(place(deepest.voxel));
    window_->actions()[Act::ToolSeed]->trigger();
    drag(axial(), middle, middle + QPointF(deepest.depth_mm / axial().mm_per_pixel(), 0));
    window_->actions()[Act::ToolCrosshair]->trigger();
    ASSERT_FALSE(scene().meshes.empty());
    organ.mesh = scene().meshes.back().id;
    EXPECT_NEAR(scene().meshes.back().seed.radius_mm, deepest.depth_mm, 2 * axial().mm_per_pixel());
  }
  ASSERT_EQ(scene().meshes.size(), organs.size());
  if (!bench().running()) window_->actions()[Act::RunPause]->trigger();
  ASSERT_TRUE(wait_for_rest());
  while (true) {
    bool corrected = false;
    for (Organ& organ : organs) {
      const Mask mask = now(organ);
      const double now_dice = dice(organ.truth, mask);
      std::printf("%s after %d points: Dice %.4f\n", organ.name, organ.points, now_dice);
      organ.reached = std::max(organ.reached, now_dice);
      if (now_dice >= organ.dice || organ.points == kMostPoints) continue;
      corrected = true;
      const WorstError error = *worst_error(organ.truth, mask);
      bench().set_active_mesh(organ.mesh);
      const QPointF at = show(place(error.voxel));
      mouse(axial(), QEvent::MouseMove, at, Qt::NoButton, Qt::NoButton);
      press_key(error.too_little ? Qt::Key_I : Qt::Key_O);
      ++organ.points;
    }
    if (!corrected) break;
    ASSERT_TRUE(wait_for_rest());
  }
  std::vector<std::uint8_t> taken(image->geometry().voxel_count());
  for (const Organ& organ : organs) {
    const Mask mask = now(organ);
    EXPECT_GE(organ.reached, organ.least) << organ.name << " with " << organ.points << " points";
    int shared = 0;
    for (std::size_t v = 0; v < taken.size(); ++v) {
      shared += taken[v] && mask.voxels[v];
      taken[v] |= mask.voxels[v];
    }
    EXPECT_EQ(shared, 0) << organ.name;
  }
}

/// A seed in bowel beside the kidney.
TEST_F(OrgansTest, AForcedLeakIsSaid) {
  const std::optional<Volume> image = volume_of("ct_abdomen/ct.nii.gz");
  if (!image) GTEST_SKIP() << "the CT of the abdomen is not on this machine";
  Scene empty;
  empty.simulation = default_simulation_parameters();
  bench().open(std::move(empty), *image);
  QApplication::processEvents();
  const QPointF middle = show({78.956, -164.319, 316.302});
  window_->actions()[Act::ToolSeed]->trigger();
  drag(axial(), middle, middle + QPointF(6 / axial().mm_per_pixel(), 0));
  QElapsedTimer said;
  said.start();
  const auto warned = [&] { return window_->messages().text().contains("is unsure of its object"); };
  while (!warned() && said.elapsed() < 60000) QApplication::processEvents(QEventLoop::AllEvents, 20);
  std::printf("said after %.2f s\n", static_cast<double>(said.elapsed()) / 1000);
  EXPECT_TRUE(warned());
  const auto chip = [&] { return window_->findChild<StateChip*>("state_chip")->text().toStdString(); };
  EXPECT_TRUE(wait_until([&] { return chip() == "unsure" || chip() == "leaking"; })) << chip();
}

}  // namespace
}  // namespace simplexseg
