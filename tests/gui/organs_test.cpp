// SPDX-License-Identifier: Apache-2.0
// Complete workflow: six organs of a CT with default settings, one seed and at most six points each, from the empty
// window to a label file, by mouse and keys only. Results: docs/results/archive/window-2026-11-23.md.
// SIMPLEXSEG_PICTURES names a folder for pictures of the window.
#include <QAbstractButton>
#include <QAction>
#include <QApplication>
#include <QElapsedTimer>
#include <QFile>
#include <QFileDialog>
#include <QTest>
#include <QTimer>
#include <algorithm>

#include "core/error.h"
#include "field/robot_user.h"
#include "gui/look/theme.h"
#include "gui/panels/mesh_card.h"
#include "gui/panels/mesh_panel.h"
#include "gui/window/message_bar.h"
#include "gui/window/start_page.h"
#include "gui/window/state_chip.h"
#include "image/rasterise.h"
#include "io/platform/data_path.h"
#include "io/volume/volume_io.h"
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
  double dice;   ///< target: no further points are placed
  double least;  ///< required Dice, with at most kMostPoints points
  Mask truth{};
  ItemId mesh = 0;
  int points = 0;
  double reached = 0;  ///< largest Dice of a settled state; a user can undo later points
};

class OrgansTest : public WindowTest {
 protected:
  void press_key(Qt::Key key, Qt::KeyboardModifiers modifiers = {}) {
    QTest::keyClick(window_->windowHandle(), key, modifiers);
    ++keys_;
  }
  void click(QWidget& widget) {
    QTest::mouseClick(&widget, Qt::LeftButton);
    ++clicks_;
  }
  /// Handles events for `ms`, and records the longest time without response.
  void process_events(int ms) {
    QElapsedTimer timer;
    timer.start();
    QApplication::processEvents(QEventLoop::AllEvents, ms);
    longest_pause_ms_ = std::max(longest_pause_ms_, static_cast<int>(timer.elapsed()) - ms);
  }
  /// Scrolls the axial view to the slice of a position; returns its pixel.
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
  /// Waits until nothing moves and no field is being solved.
  bool wait_until_settled() {
    constexpr int most_ms = 120000, still_ms = 300;
    QElapsedTimer all, still;
    all.start();
    bool settled = false;
    const auto follows = QObject::connect(&bench(), &Workbench::advanced, [&](const Advance& done) {
      if (done.at_rest && !settled) still.start();
      settled = done.at_rest;
    });
    const auto is_still = [&] {
      return settled && bench().session().solving_mesh() == 0 && still.elapsed() > still_ms;
    };
    while (!is_still() && all.elapsed() < most_ms) process_events(20);
    QObject::disconnect(follows);
    return is_still();
  }
  Mask mask_of_mesh(const Organ& organ) {
    return rasterise(bench().session().scene().find_mesh(organ.mesh)->mesh, organ.truth.geometry);
  }
  Eigen::Vector3d place(const std::array<int, 3>& voxel) {
    return bench().session().volume().geometry().world_from_index() * Eigen::Vector3d(voxel[0], voxel[1], voxel[2]);
  }
  void save_picture(const char* name) {
    const QString folder = qEnvironmentVariable("SIMPLEXSEG_PICTURES");
    if (!folder.isEmpty()) window_->save_picture(folder + "/" + name + ".png");
  }
  void seed(Organ& organ) {
    const WorstError deepest = *deepest_voxel(organ.truth);
    const QPointF middle = show(place(deepest.voxel));
    press_key(Qt::Key_4);
    drag(axial(), middle, middle + QPointF(deepest.depth_mm / axial().mm_per_pixel(), 0));
    ++clicks_;
    ASSERT_FALSE(scene().meshes.empty());
    organ.mesh = scene().meshes.back().id;
    EXPECT_NEAR(scene().meshes.back().seed.radius_mm, deepest.depth_mm, 2 * axial().mm_per_pixel());
  }
  /// Places an inside or outside point at the largest error.
  void correct(Organ& organ, const Mask& mask) {
    const WorstError error = *worst_error(organ.truth, mask);
    for (MeshCard* card : window_->findChild<MeshPanel*>()->cards())
      if (card->mesh() == organ.mesh && bench().view.active_mesh != organ.mesh) click(*card);
    ASSERT_EQ(bench().view.active_mesh, organ.mesh);
    const QPointF at = show(place(error.voxel));
    mouse(axial(), QEvent::MouseMove, at, Qt::NoButton, Qt::NoButton);
    axial().setFocus();  // as if the mouse had entered it
    const std::size_t points = scene().points.size();
    press_key(error.too_little ? Qt::Key_I : Qt::Key_O);
    ASSERT_EQ(scene().points.size(), points + 1);
    ++organ.points;
  }
  /// Saves the labels with Ctrl+L, and Return in the dialog.
  void save_labels() {
    QTimer confirm;
    QObject::connect(&confirm, &QTimer::timeout, [&] {
      auto* dialog = qobject_cast<QFileDialog*>(QApplication::activeModalWidget());
      if (!dialog) return;
      confirm.stop();
      ++keys_;
      QTest::keyClick(dialog, Qt::Key_Return);
    });
    confirm.start(50);
    window_->messages().clear();
    press_key(Qt::Key_L, Qt::ControlModifier);
  }

  int clicks_ = 0, keys_ = 0, longest_pause_ms_ = 0;
};

TEST_F(OrgansTest, SixOrgansFromAnEmptyWindowToLabels) {
  const std::optional<Volume> image = volume_of("ct_abdomen/ct.nii.gz"), labels = volume_of("ct_abdomen/labels.nii.gz");
  if (!image || !labels) GTEST_SKIP() << "the CT of the abdomen is not on this machine";
  if (qEnvironmentVariableIsSet("SIMPLEXSEG_PICTURES")) theme::apply(*qApp, true);
  const QString path = folder_.filePath("ct.nii.gz");
  write_volume(path.toStdString(), *image);
  window_->start_page().show_recent({path});
  for (QAbstractButton* entry : window_->start_page().findChildren<QAbstractButton*>("recent"))
    if (entry->toolTip().contains("ct.nii.gz")) click(*entry);
  ASSERT_TRUE(wait_until([&] { return bench().has_volume(); }));
  ASSERT_TRUE(has_keys());
  axial().setFocus();
  // Targets of the first four: docs/results/archive/evidence-2026-11-23c.md.
  std::vector<Organ> organs{{"left kidney", 3, 0.90, 0.88}, {"right kidney", 2, 0.90, 0.88},
                            {"bladder", 21, 0.92, 0.92},    {"L3", 29, 0.87, 0.85},
                            {"L2", 30, 0.87, 0.80},         {"L4", 28, 0.87, 0.80}};
  for (Organ& organ : organs) {
    organ.truth = mask_of(*labels, organ.label);
    organ.truth.geometry = image->geometry();
    organ.truth = largest_part(organ.truth);
    ASSERT_NO_FATAL_FAILURE(seed(organ));
  }
  ASSERT_EQ(scene().meshes.size(), organs.size());
  save_picture("seeded");
  ASSERT_TRUE(wait_until_settled());  // a seed starts the run
  save_picture("first");
  while (true) {
    bool corrected = false;
    for (Organ& organ : organs) {
      const Mask mask = mask_of_mesh(organ);
      const double now_dice = dice(organ.truth, mask);
      std::printf("%s after %d points: Dice %.4f\n", organ.name, organ.points, now_dice);
      organ.reached = std::max(organ.reached, now_dice);
      if (now_dice >= organ.dice || organ.points == kMostPoints) continue;
      corrected = true;
      ASSERT_NO_FATAL_FAILURE(correct(organ, mask));
    }
    if (!corrected) break;
    ASSERT_TRUE(wait_until_settled());
  }
  save_picture("corrected");
  window_->actions()[Act::ShowFill]->trigger();
  save_picture("filled");
  window_->actions()[Act::ShowFill]->trigger();
  save_labels();
  ASSERT_TRUE(wait_until([&] { return window_->messages().text().startsWith("Saved"); }))
      << window_->messages().text().toStdString();
  const Volume saved = read_volume(folder_.filePath("ct-labels.nii.gz").toStdString());
  std::vector<int> meshes(image->geometry().voxel_count());
  double sum = 0;
  for (const Organ& organ : organs) {
    const Mask mask = mask_of_mesh(organ);
    for (std::size_t v = 0; v < meshes.size(); ++v) meshes[v] += mask.voxels[v];
    const Mask label = mask_of(saved, scene().find_mesh(organ.mesh)->label);
    const double saved_dice = dice(organ.truth, label);
    sum += saved_dice;
    std::printf("%s in the file, %d points: Dice %.4f\n", organ.name, organ.points, saved_dice);
    EXPECT_GE(organ.reached, organ.least) << organ.name << " with " << organ.points << " points";
  }
  // Touching vertebrae may share a few voxels; the label file assigns each to one of them.
  const auto in = [&](int least) {
    return std::count_if(meshes.begin(), meshes.end(), [=](int n) { return n >= least; });
  };
  EXPECT_LE(in(2), in(1) / 1000);
  EXPECT_GE(sum / static_cast<double>(organs.size()), 0.85);
  std::printf("mean Dice %.4f, %d clicks, %d keys; longest pause of the window %d ms\n",
              sum / static_cast<double>(organs.size()), clicks_, keys_, longest_pause_ms_);
  EXPECT_LE(clicks_, 60);
  EXPECT_LE(keys_, 6 + 2 + 6 * kMostPoints);
}

/// Places the seed in the bowel next to the kidney.
TEST_F(OrgansTest, AForcedLeakIsReported) {
  const std::optional<Volume> image = volume_of("ct_abdomen/ct.nii.gz");
  if (!image) GTEST_SKIP() << "the CT of the abdomen is not on this machine";
  Scene empty;
  empty.simulation = default_simulation_parameters();
  bench().open(std::move(empty), *image);
  QApplication::processEvents();
  const QPointF middle = show({78.956, -164.319, 316.302});
  window_->actions()[Act::ToolSeed]->trigger();
  drag(axial(), middle, middle + QPointF(6 / axial().mm_per_pixel(), 0));
  QElapsedTimer timer;
  timer.start();
  const auto warned = [&] { return window_->messages().text().contains("spreads without finding a border"); };
  while (!warned() && timer.elapsed() < 60000) QApplication::processEvents(QEventLoop::AllEvents, 20);
  std::printf("reported after %.2f s\n", static_cast<double>(timer.elapsed()) / 1000);
  EXPECT_TRUE(warned());
  const auto chip = [&] { return window_->findChild<StateChip*>("state_chip")->text().toStdString(); };
  EXPECT_TRUE(wait_until([&] { return chip() == "spreading"; })) << chip();
}

}  // namespace
}  // namespace simplexseg
