// SPDX-License-Identifier: Apache-2.0
// Comparison of two settings from the same start.
#include <QAction>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFile>
#include <QLabel>
#include <QPushButton>
#include <QTest>
#include <QToolButton>

#include "core/error.h"
#include "gpu/backend.h"
#include "gui/panels/force_panel.h"
#include "gui/panels/parameter_row.h"
#include "gui/panels/simulation_rows.h"
#include "gui/views/space_view.h"
#include "gui/window/compare/compare_window.h"
#include "gui/window/message_bar.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

constexpr int kA = 0, kB = 1;

class CompareTest : public PausedPhantomTest {
 protected:
  void SetUp() override {
    PausedPhantomTest::SetUp();
    if (IsSkipped()) return;
    window_->set_engine_maker([] { return make_cpu_engine(1); });
  }
  void TearDown() override {
    delete compare_;
    PausedPhantomTest::TearDown();
  }
  void compare() {
    compare_ = window_->compare_settings();
    ASSERT_NE(compare_, nullptr);
    QApplication::processEvents();
  }
  Workbench& side(int side) { return compare_->comparison().side(side); }
  const MeshItem& item(int side) { return compare_->comparison().item(side); }
  void set_smoothing(int side, double weight) {
    compare_->forces(side).row(ForceId::Smoothing, 0)->number()->setValue(weight);
  }
  std::vector<Eigen::Vector3f> positions(int side) {
    return this->side(side).session().scene().find_mesh(compare_->comparison().mesh())->mesh.positions;
  }
  /// Adds the voxels of the phantom as the reference of the mesh.
  void add_reference() {
    const Volume& image = bench().session().volume();
    Volume labels(image.geometry(), VoxelType::UInt8);
    const double threshold = (image.range().min + image.range().max) / 2;
    const auto voxels = labels.voxels<std::uint8_t>();
    const auto [ni, nj, nk] = image.geometry().size;
    for (int k = 0; k < nk; ++k)
      for (int j = 0; j < nj; ++j)
        for (int i = 0; i < ni; ++i) voxels[labels.offset(i, j, k)] = image.value(i, j, k) > threshold;
    bench().add_reference("truth", labels);
    bench().apply(SetReference{scene().meshes[0].id, Reference{"truth", std::nullopt}});
  }

  QPointer<CompareWindow> compare_;
};

TEST_F(CompareTest, BothSidesBeginAtTheStartWithTheSettingsOfTheWindow) {
  const ItemId mesh = scene().meshes[0].id;
  const std::vector<Eigen::Vector3f> start = scene().meshes[0].mesh.positions;
  bench().apply(AddMesh{"other", {scene().meshes[0].seed.centre_mm, 5}, {}, 0});
  bench().set_active_mesh(mesh);
  bench().apply(SetForceParameter{mesh, ForceId::Smoothing, 0, 0.25f});
  bench().advance_steps(20);
  const std::vector<Eigen::Vector3f> moved = scene().find_mesh(mesh)->mesh.positions;
  ASSERT_NE(moved, start);
  (*window_).actions()[Act::Compare]->trigger();
  compare_ = window_->findChild<CompareWindow*>();
  ASSERT_NE(compare_, nullptr);
  EXPECT_FALSE(bench().running());
  for (const int s : {kA, kB}) {
    EXPECT_EQ(positions(s), start);
    EXPECT_EQ(item(s).parameters.weight(ForceId::Smoothing), 0.25f);
    EXPECT_EQ(side(s).scene().meshes.size(), 2u);
    EXPECT_TRUE(side(s).scene().meshes[1].locked);
  }
  EXPECT_TRUE(compare_->comparison().differences().empty());
  for (const int s : {kA, kB}) side(s).advance_steps(30);
  EXPECT_EQ(positions(kA), positions(kB));  // the same settings: the same bits
  EXPECT_NE(positions(kA), start);
  EXPECT_EQ(scene().find_mesh(mesh)->mesh.positions, moved);  // the mesh of the main window is unchanged
}

TEST_F(CompareTest, ASettingOfOneSideActsOnThatSideOnlyAndIsListed) {
  compare();
  set_smoothing(kB, 0.1);
  EXPECT_EQ(item(kA).parameters.weight(ForceId::Smoothing), 0.5f);
  EXPECT_EQ(item(kB).parameters.weight(ForceId::Smoothing), 0.1f);
  EXPECT_EQ(scene().meshes[0].parameters.weight(ForceId::Smoothing), 0.5f);
  EXPECT_EQ(compare_->table_text("Smoothing, weight", kA), "0.5");
  EXPECT_EQ(compare_->table_text("Smoothing, weight", kB), "0.1");
  const int budget = find_parameter(simulation_table(), "frame_budget");
  compare_->simulation(kA).row(budget)->number()->setValue(3);
  EXPECT_EQ(compare_->table_text("Frame budget", kA), "3 ms");
  EXPECT_EQ(compare_->comparison().differences().size(), 2u);
  for (const int s : {kA, kB}) side(s).advance_steps(30);
  EXPECT_NE(positions(kA), positions(kB));
  set_smoothing(kB, 0.5);
  EXPECT_EQ(compare_->table_text("Smoothing, weight", kB), "");
}

TEST_F(CompareTest, PointsViewsAndRunsAreTheSameOnBothSides) {
  compare();
  compare_->comparison().pause();
  SliceView &left = compare_->views(kA).slice(0), &right = compare_->views(kB).slice(0);
  const QPointF at = left.pixel_of(side(kA).view.crosshair_mm) + QPointF(40, 25);
  drag(left, at, at + QPointF(6, 4), Qt::LeftButton, Qt::ShiftModifier);
  ASSERT_EQ(side(kA).scene().points.size(), 1u);
  ASSERT_EQ(side(kB).scene().points.size(), 1u);
  EXPECT_EQ(side(kA).scene().points[0].id, side(kB).scene().points[0].id);
  EXPECT_EQ(side(kA).scene().points[0].position_mm, side(kB).scene().points[0].position_mm);
  EXPECT_TRUE(scene().points.empty());

  drag(right, QPointF(50, 60), QPointF(80, 70));
  EXPECT_EQ(side(kA).view.crosshair_mm, side(kB).view.crosshair_mm);
  EXPECT_NE(side(kA).view.crosshair_mm, bench().view.crosshair_mm);
  const double before = left.mm_per_pixel();
  wheel(right, QPointF(90, 90), 3, Qt::ControlModifier);
  EXPECT_LT(left.mm_per_pixel(), 0.95 * before);
  EXPECT_EQ(left.mm_per_pixel(), right.mm_per_pixel());
  EXPECT_EQ(left.world_of({10, 10}), right.world_of({10, 10}));

  side(kB).apply(DeletePoint{side(kB).scene().points[0].id});
  EXPECT_TRUE(side(kA).scene().points.empty());

  auto* run = compare_->findChild<QToolButton*>("compare_run");
  run->click();
  EXPECT_TRUE(side(kA).running() && side(kB).running());
  EXPECT_EQ(run->text(), "Pause");
  side(kA).pause();
  EXPECT_FALSE(side(kB).running());
  EXPECT_EQ(run->text(), "Run");
}

TEST_F(CompareTest, BothSidesSettleAndAreMeasured) {
  add_reference();
  bench().apply(SetParameters{scene().meshes[0].id, default_force_parameters(), std::nullopt});
  compare();
  set_smoothing(kB, 0.05);
  compare_->comparison().run();
  EXPECT_TRUE(wait_until([&] { return compare_->comparison().settled(kA) && compare_->comparison().settled(kB); }));
  EXPECT_GT(compare_->comparison().steps(kA), 0);
  EXPECT_GT(compare_->comparison().seconds(kB), 0);
  EXPECT_TRUE(wait_until([&] {
    return compare_->table_text("Dice, A against B", kA).toDouble() > 0 &&
           !compare_->comparison().error_plot().series.empty();
  }));
  // Measurements follow with a delay.
  EXPECT_TRUE(wait_until([&] {
    return compare_->table_text("Dice", kA).toDouble() > 0.9 && compare_->table_text("Dice", kB).toDouble() > 0.9 &&
           compare_->table_text("Volume", kA) != compare_->table_text("Volume", kB);
  }));
  for (const int s : {kA, kB}) {
    EXPECT_TRUE(compare_->table_text("Volume", s).endsWith(" ml")) << compare_->table_text("Volume", s).toStdString();
    const QString distance = compare_->table_text("HD95", s);
    ASSERT_TRUE(distance.endsWith(" mm")) << distance.toStdString();
    EXPECT_LT(distance.chopped(3).toDouble(), 2);
    EXPECT_GT(compare_->table_text("Vertices", s).toInt(), 100);
  }
  const std::string csv = compare_->comparison().csv();
  EXPECT_EQ(csv.rfind("setting,mesh,seconds", 0), 0u);
  EXPECT_NE(csv.find("\nA,object,"), std::string::npos);
  EXPECT_NE(csv.find("\nB,object,"), std::string::npos);
  const QString table = folder_.filePath("both.csv"), picture = folder_.filePath("both.png");
  compare_->save_to(table);
  compare_->save_to(picture);
  QFile file(table);
  ASSERT_TRUE(file.open(QFile::ReadOnly));
  EXPECT_EQ(file.readAll().toStdString(), compare_->comparison().csv());
  EXPECT_GT(QFileInfo(picture).size(), 1000);
  EXPECT_THROW(compare_->save_to(folder_.filePath("none/both.png")), Error);

  const std::vector<Eigen::Vector3f> settled = positions(kA);
  compare_->comparison().pause();
  compare_->comparison().restart();
  EXPECT_EQ(compare_->comparison().steps(kA), 0);
  EXPECT_TRUE(compare_->comparison().running());
  EXPECT_NE(positions(kA), settled);
}

TEST_F(CompareTest, TheSettingsOfASideAreAppliedAsOneUndoableAction) {
  compare();
  set_smoothing(kB, 0.25);
  compare_->simulation(kB).row(find_parameter(simulation_table(), "frame_budget"))->number()->setValue(3);
  for (auto* button : compare_->findChildren<QPushButton*>())
    if (button->text() == "Use &B") button->click();
  QApplication::sendPostedEvents(nullptr, QEvent::DeferredDelete);
  EXPECT_EQ(compare_, nullptr);
  EXPECT_EQ(scene().meshes[0].parameters.weight(ForceId::Smoothing), 0.25f);
  EXPECT_EQ(scene().simulation.frame_budget_ms, 3);
  bench().apply(Undo{});
  EXPECT_EQ(scene().meshes[0].parameters.weight(ForceId::Smoothing), 0.5f);
  EXPECT_NE(scene().simulation.frame_budget_ms, 3);
}

TEST_F(CompareTest, TheWindowOpensAtTheSegmentation) {
  bench().apply(ResetPose{0});
  bench().set_crosshair(bench().session().volume().geometry().centre_mm() + Eigen::Vector3d(0, 0, 25));
  compare();
  const MeshItem& item = compare_->comparison().item(kA);
  EXPECT_LT((side(kA).view.crosshair_mm - item.seed.centre_mm).norm(), 2);
  EXPECT_EQ(side(kA).view.crosshair_mm, side(kB).view.crosshair_mm);
  EXPECT_NE(bench().view.crosshair_mm, side(kA).view.crosshair_mm) << "the main window stays at its slice";
}

TEST_F(CompareTest, ASliceThatCutsTheSegmentationStays) {
  bench().set_crosshair(bench().session().volume().geometry().centre_mm() + Eigen::Vector3d(0, 0, 5));
  const Eigen::Vector3d chosen = bench().view.crosshair_mm;
  compare();
  EXPECT_EQ(side(kA).view.crosshair_mm, chosen);
}

TEST_F(CompareTest, OneViewOrAllFourAreShownOnBothSides) {
  compare();
  EXPECT_TRUE(compare_->views(kA).slice(0).isVisible());
  EXPECT_FALSE(compare_->views(kA).space().isVisible());
  auto* shown = compare_->findChild<QComboBox*>();
  for (auto* box : compare_->findChildren<QComboBox*>())
    if (box->accessibleName() == "View shown on both sides") shown = box;
  shown->setCurrentIndex(4);
  for (const int s : {kA, kB}) EXPECT_TRUE(compare_->views(s).space().isVisible());
  mouse(compare_->views(kB).slice(1), QEvent::MouseButtonDblClick, {20, 20}, Qt::LeftButton, Qt::LeftButton);
  EXPECT_EQ(shown->currentText(), "Sagittal");
  for (const int s : {kA, kB}) {
    EXPECT_TRUE(compare_->views(s).slice(1).isVisible());
    EXPECT_FALSE(compare_->views(s).slice(0).isVisible());
  }
}

TEST_F(CompareTest, WithoutAnEngineAMessageIsShownAndTheWindowStaysUsable) {
  window_->set_engine_maker([]() -> std::unique_ptr<Engine> { throw Error("engine", "none is left", "try again"); });
  EXPECT_EQ(window_->compare_settings(), nullptr);
  EXPECT_TRUE(window_->messages().text().contains("none is left"));
  EXPECT_TRUE(bench().apply(DeleteMesh{scene().meshes[0].id}));
  EXPECT_FALSE(window_->actions()[Act::Compare]->isEnabled());
}

}  // namespace
}  // namespace simplexseg
