// SPDX-License-Identifier: Apache-2.0
// The first minute of use: from an empty window to a growing segmentation; the cards of the segmentations.
#include <QAbstractButton>
#include <QAction>
#include <QDoubleSpinBox>
#include <QLabel>
#include <QLineEdit>
#include <QSpinBox>
#include <QToolButton>
#include <algorithm>
#include <cstring>

#include "gui/panels/mesh_card.h"
#include "gui/panels/mesh_panel.h"
#include "gui/views/slice_view.h"
#include "gui/window/file_actions.h"
#include "gui/window/start_page.h"
#include "gui/window/state_chip.h"
#include "gui/window/step_strip.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/frame_loop.h"
#include "gui/workbench/run_state.h"
#include "io/volume/volume_io.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class FirstMinuteTest : public WindowTest {
 protected:
  RunState chip() { return window_->findChild<StateChip*>("state_chip")->state(); }
  QString chip_text() { return window_->findChild<StateChip*>("state_chip")->text(); }
  void open_volume() {
    Scene empty;
    empty.simulation = default_simulation_parameters();
    bench().open(empty, make_phantom("sphere", {}).image);
    QApplication::processEvents();
  }
  const std::vector<MeshCard*>& cards() { return window_->findChild<MeshPanel*>()->cards(); }
  QToolButton* button_of(const MeshCard& card, const char* name) {
    for (QToolButton* button : card.findChildren<QToolButton*>())
      if (button->accessibleName().startsWith(name)) return button;
    return nullptr;
  }
};

TEST_F(FirstMinuteTest, AnEmptyWindowLeadsToAVolume) {
  EXPECT_TRUE(window_->start_page().isVisible());
  EXPECT_EQ(window_->steps().step(), 0);
  const QString path = folder_.filePath("ball.nii");
  write_volume(path.toStdString(), make_phantom("sphere", {}).image);
  window_->start_page().show_recent({folder_.filePath("gone.nii"), path});
  QAbstractButton* entry = nullptr;
  for (QAbstractButton* button : window_->start_page().findChildren<QAbstractButton*>("recent")) {
    EXPECT_FALSE(button->toolTip().contains("gone.nii"));
    if (button->toolTip().contains("ball.nii")) entry = button;
  }
  ASSERT_NE(entry, nullptr);
  entry->click();
  ASSERT_TRUE(wait_until([&] { return bench().has_volume(); }));
  EXPECT_FALSE(window_->start_page().isVisible());
  EXPECT_EQ(window_->steps().step(), 1);
}

TEST_F(FirstMinuteTest, ASeedStartsTheRunAndTheNextDragCorrects) {
  open_volume();
  EXPECT_EQ(chip(), RunState::Nothing);
  const QString before = window_->steps().hint();
  window_->actions()[Act::ToolSeed]->trigger();
  EXPECT_NE(window_->steps().hint(), before);
  const QPointF middle = axial().pixel_of(bench().view.crosshair_mm);
  drag(axial(), middle, middle + QPointF(30, 0));
  ASSERT_EQ(scene().meshes.size(), 1u);
  EXPECT_TRUE(bench().running());
  EXPECT_EQ(chip(), RunState::Running);
  EXPECT_EQ(bench().view.tool, Tool::Crosshair);
  EXPECT_EQ(window_->steps().step(), 2);
  bench().pause();
  EXPECT_EQ(chip(), RunState::Paused);
  EXPECT_EQ(chip_text(), "paused");
  // A pause by the user is respected.
  ASSERT_TRUE(bench().apply(AddMesh{"", Seed{bench().view.crosshair_mm + Eigen::Vector3d(12, 0, 0), 4}, {}, 0}));
  EXPECT_FALSE(bench().running());
}

TEST_F(FirstMinuteTest, TheChipShowsTheSettledState) {
  open_phantom();
  bench().apply(SetForceParameter{0, ForceId::Smoothing, 0, 0});
  bench().apply(SetSimulationParameter{find_parameter(simulation_table(), "final_vertices"), 20});
  bench().run();
  EXPECT_TRUE(wait_until([&] { return chip() == RunState::Settled; }));
  EXPECT_EQ(chip_text(), "settled");
}

TEST_F(FirstMinuteTest, ChipCardAndButtonShowOneState) {
  open_phantom();
  bench().pause();
  Scene still = scene();
  const Volume volume = bench().session().volume();
  still.meshes[0].parameters.values[static_cast<int>(ForceId::Smoothing)][0] = 0;  // no force moves the mesh
  still.simulation.final_vertices = static_cast<float>(still.meshes[0].mesh.vertex_count());
  const auto card_text = [&] {
    QStringList texts;
    for (const QLabel* label : cards()[0]->findChildren<QLabel*>()) texts << label->text();
    return texts;
  };
  const auto button = [&] { return window_->findChild<QToolButton*>("run")->text().remove('&'); };
  const auto show = [&](RunState state, const QString& text, const QString& action) {
    ASSERT_TRUE(wait_until([&] { return chip() == state && card_text().contains(text) && button() == action; }))
        << chip_text().toStdString() << "; " << card_text().join(',').toStdString() << "; " << button().toStdString();
    EXPECT_EQ(chip_text(), text);
  };
  bench().open(still, volume);
  show(RunState::Paused, "paused", "Run");
  bench().run();
  show(RunState::Settled, "settled", "Run");  // nothing moves, so there is nothing to pause
  window_->actions()[Act::RunPause]->trigger();
  EXPECT_TRUE(bench().running());
  EXPECT_FALSE(window_->loop().settled()) << "it runs again";
  show(RunState::Settled, "settled", "Run");
  // One vertex through to the other side.
  MeshItem& item = still.meshes[0];
  item.mesh.positions[0] = 2 * item.seed.centre_mm.cast<float>() - item.mesh.positions[0];
  item.previous = item.mesh.positions;
  bench().open(still, volume);
  bench().run();
  show(RunState::Overlapping, "overlaps itself", "Run");
  bench().pause();
  show(RunState::Overlapping, "overlaps itself", "Run");
}

TEST_F(FirstMinuteTest, TheEntriesOfAnEmptyWindowKeepTheirTexts) {
  const auto texts = [&] {
    QStringList all;
    for (const char* name : {"first_entry", "entry"}) {
      const auto* button = window_->start_page().findChild<QToolButton*>(name);
      all << button->text() << (button->icon().isNull() ? "no icon" : "icon") << (button->isEnabled() ? "on" : "off");
    }
    return all;
  };
  const QStringList before = texts();
  EXPECT_TRUE(before[0].contains("Open a volume or a scene")) << before[0].toStdString();
  EXPECT_TRUE(before[0].contains("Ctrl+O"));
  EXPECT_FALSE(before.contains("no icon"));
  window_->files().open(folder_.filePath("none.nii"));
  EXPECT_TRUE(texts().contains("off")) << "while a file is read";
  ASSERT_TRUE(wait_until([&] { return !window_->job().busy(); }));
  EXPECT_EQ(texts(), before);
}

TEST_F(FirstMinuteTest, ACardShowsAndChangesItsMesh) {
  open_phantom();
  bench().pause();
  bench().apply(AddMesh{"other", Seed{bench().view.crosshair_mm + Eigen::Vector3d(15, 0, 0), 6}, {}, 0});
  ASSERT_EQ(cards().size(), 2u);
  MeshCard& card = *cards()[0];
  auto* name = card.findChild<QLineEdit*>();
  EXPECT_EQ(name->text(), "object");
  name->setText("kidney");
  emit name->editingFinished();
  EXPECT_EQ(scene().meshes[0].name, "kidney");
  name->setText("other");  // taken
  emit name->editingFinished();
  EXPECT_EQ(scene().meshes[0].name, "kidney");
  EXPECT_EQ(name->text(), "kidney");
  card.findChild<QSpinBox*>()->setValue(7);
  EXPECT_EQ(scene().meshes[0].label, 7);
  button_of(card, "Shown")->click();
  EXPECT_FALSE(scene().meshes[0].visible);
  // A sphere of 12 mm has 7.24 ml, its mesh a little less.
  double millilitres = 0;
  for (const QLabel* label : card.findChildren<QLabel*>())
    if (label->text().endsWith(" ml")) millilitres = label->text().section(' ', 0, 0).toDouble();
  EXPECT_NEAR(millilitres, 7, 0.3);
  EXPECT_EQ(bench().view.active_mesh, scene().meshes[1].id);
  mouse(card, QEvent::MouseButtonPress, QPointF(3, 3), Qt::LeftButton, Qt::LeftButton);
  EXPECT_EQ(bench().view.active_mesh, scene().meshes[0].id);
}

TEST_F(FirstMinuteTest, NothingOfAMicroscopicImageRoundsToZero) {
  open_phantom();
  constexpr double kVoxelMm = 0.008;
  const Volume& plain = bench().session().volume();
  VolumeGeometry geometry = plain.geometry();
  geometry.spacing_mm.setConstant(kVoxelMm);
  geometry.origin_mm.setZero();
  Volume volume(geometry, plain.type());
  std::memcpy(volume.data(), plain.data(), plain.bytes());
  Scene empty;
  empty.simulation = default_simulation_parameters();
  bench().open(empty, std::move(volume));
  auto* radius = window_->findChild<MeshPanel*>()->findChild<QDoubleSpinBox*>();
  EXPECT_NEAR(radius->value(), 0.1 * 64 * kVoxelMm, 1e-3);
  EXPECT_LE(radius->minimum(), kVoxelMm);
  bench().apply(AddMesh{"cell", Seed{geometry.centre_mm(), 0.03}, {}, 0});
  bench().pause();
  QStringList texts;
  ASSERT_TRUE(wait_until([&] {
    texts.clear();
    for (const QLabel* label : window_->findChildren<QLabel*>()) texts << label->text();
    return std::ranges::any_of(texts, [](const QString& text) { return text.endsWith(" \u00b5m\u00b3"); });
  })) << texts.join('|').toStdString();
  for (const QString& text : texts) EXPECT_FALSE(text.startsWith("0.00 ")) << text.toStdString();
  const auto position = std::ranges::find_if(texts, [](const QString& text) { return text.startsWith("LPS"); });
  ASSERT_NE(position, texts.end());
  EXPECT_EQ(position->section(' ', 2, 2).section('.', 1).size(), 4) << position->toStdString();
}

TEST_F(FirstMinuteTest, ALockedMeshDoesNotMove) {
  open_phantom();
  const ItemId locked = scene().meshes[0].id;
  bench().apply(AddMesh{"free", Seed{bench().view.crosshair_mm + Eigen::Vector3d(2, 0, 0), 9}, {}, locked});
  bench().pause();
  bench().advance_steps(5);
  button_of(*cards()[0], "Locked")->click();
  ASSERT_TRUE(scene().meshes[0].locked);
  const std::vector<Eigen::Vector3f> before = scene().meshes[0].mesh.positions, free = scene().meshes[1].mesh.positions;
  bench().advance_steps(60);
  EXPECT_EQ(scene().meshes[0].mesh.positions, before);
  EXPECT_NE(scene().meshes[1].mesh.positions, free);
  bench().apply(ResetPose{0});
  EXPECT_EQ(scene().meshes[0].mesh.positions, before);
  EXPECT_FALSE(bench().apply(AddPoint{locked, bench().view.crosshair_mm}));
  EXPECT_FALSE(bench().apply(RefineMesh{locked}));
  button_of(*cards()[0], "Locked")->click();
  EXPECT_FALSE(scene().meshes[0].locked);
  bench().advance_steps(20);
  EXPECT_NE(scene().meshes[0].mesh.positions, before);
}

}  // namespace
}  // namespace simplexseg
