// SPDX-License-Identifier: Apache-2.0
// Keyboard focus: keys act on the views, except while the user is typing.
#include <QAction>
#include <QDoubleSpinBox>
#include <QEnterEvent>
#include <QLineEdit>
#include <QMenu>
#include <QTest>

#include "forces/evidence.h"
#include "gui/panels/force_panel.h"
#include "gui/panels/parameter_row.h"
#include "gui/window/message_bar.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class KeysTest : public PausedPhantomTest {
 protected:
  void SetUp() override {
    PausedPhantomTest::SetUp();
    if (IsSkipped()) return;
    ASSERT_TRUE(has_keys());
    number_ = window_->panels().forces().row(ForceId::Smoothing, 0)->number();
  }
  void press(Qt::Key key) { QTest::keyClick(window_->windowHandle(), key); }
  void press(char key) { QTest::keyClick(window_->windowHandle(), key); }
  /// Types a number: clicks the field, selects all, and presses the keys.
  void type(const char* text) {
    QTest::mouseClick(number_, Qt::LeftButton, {}, QPoint(12, number_->height() / 2));
    number_->selectAll();
    for (const char* key = text; *key; ++key) press(*key);
  }
  void enter_view() {
    QEnterEvent event(QPointF(50, 50), QPointF(50, 50), axial().mapToGlobal(QPointF(50, 50)));
    QApplication::sendEvent(&axial(), &event);
  }
  float weight() { return scene().meshes[0].parameters.weight(ForceId::Smoothing); }

  QDoubleSpinBox* number_ = nullptr;
};

TEST_F(KeysTest, AfterReturnKeysActOnTheViewsAgain) {
  type("0.7");
  press(Qt::Key_Return);
  EXPECT_FLOAT_EQ(weight(), 0.7f);
  press(Qt::Key_4);
  EXPECT_FLOAT_EQ(weight(), 0.7f);
  EXPECT_EQ(bench().view.tool, Tool::Seed);
  press(Qt::Key_Space);
  EXPECT_TRUE(bench().running());
}

TEST_F(KeysTest, KeysCutTheViewIn3dAndShowTheVolume) {
  const ViewState& view = bench().view;
  const std::pair<Qt::Key, int> planes[] = {{Qt::Key_F5, 0}, {Qt::Key_F6, 1}, {Qt::Key_F7, 2}, {Qt::Key_F8, 3}};
  for (const auto& [key, n] : planes) {
    const auto plane = static_cast<std::size_t>(n);
    press(key);
    EXPECT_TRUE(view.clip.on[plane]) << n;
    QTest::keyClick(window_->windowHandle(), key, Qt::ShiftModifier);
    EXPECT_TRUE(view.clip.flipped[plane]) << n;
    press(key);
    EXPECT_FALSE(view.clip.on[plane]) << n;
  }
  press(Qt::Key_F9);
  EXPECT_TRUE(view.clip.on[3]);
  EXPECT_FALSE(view.clip.flipped[3]) << "the viewer's side is removed";
  QTest::keyClick(window_->windowHandle(), Qt::Key_F9, Qt::ShiftModifier);
  EXPECT_FALSE(view.clip.image_on_caps);
  QTest::keyClick(window_->windowHandle(), Qt::Key_V, Qt::ShiftModifier);
  EXPECT_EQ(view.volume_mode, VolumeMode::Maximum);
  QTest::keyClick(window_->windowHandle(), Qt::Key_V, Qt::ShiftModifier);
  EXPECT_EQ(view.volume_mode, VolumeMode::Off);
}

TEST_F(KeysTest, EscapeRestoresThePreviousNumber) {
  type("3");
  press(Qt::Key_Escape);
  EXPECT_EQ(number_->text(), "0.50");
  press(Qt::Key_2);
  EXPECT_EQ(bench().view.tool, Tool::ZoomPan);
  EXPECT_FLOAT_EQ(weight(), 0.5f);
}

TEST_F(KeysTest, EscapeCancelsTheUpdateUnlessSomethingElseUsesIt) {
  bench().apply(SetForceParameter{0, ForceId::Evidence, EvidenceForce::weight, 1});
  bench().apply(SetForceParameter{0, ForceId::Evidence, EvidenceForce::source, 0});
  bench().advance(0.001);  // paused: the field is started, and no frame commits it
  const ItemId mesh = scene().meshes[0].id;
  ASSERT_EQ(bench().session().solving_mesh(), mesh);
  const QString before = number_->text();
  type("3");
  press(Qt::Key_Escape);
  EXPECT_EQ(number_->text(), before);
  EXPECT_EQ(bench().session().solving_mesh(), mesh) << "Esc restored the number";
  QMenu* const menu = window_->view_menu();
  menu->popup(window_->mapToGlobal(QPoint(60, 60)));
  QTest::keyClick(menu, Qt::Key_Escape);
  EXPECT_FALSE(menu->isVisible());
  EXPECT_EQ(bench().session().solving_mesh(), mesh) << "Esc closed the menu";
  ASSERT_TRUE(has_keys());
  press(Qt::Key_Escape);
  EXPECT_EQ(bench().session().solving_mesh(), 0u);
  EXPECT_TRUE(window_->messages().text().startsWith("Update cancelled")) << window_->messages().text().toStdString();
  const std::size_t commands = bench().session().log().size();
  press(Qt::Key_Escape);
  EXPECT_EQ(bench().session().log().size(), commands);
}

TEST_F(KeysTest, ATypedValueIsAppliedWhenTheFocusLeaves) {
  type("0.8");
  EXPECT_FLOAT_EQ(weight(), 0.5f);
  enter_view();  // the mouse over a view does not end typing
  EXPECT_TRUE(number_->hasFocus());
  QTest::mouseClick(&axial(), Qt::LeftButton, {}, QPoint(60, 60));
  EXPECT_FLOAT_EQ(weight(), 0.8f);
  EXPECT_TRUE(axial().hasFocus());
}

TEST_F(KeysTest, AnUnmodifiedNumberFieldLosesTheFocusToTheViewUnderTheMouse) {
  type("0.9");
  press(Qt::Key_Return);
  number_->setFocus(Qt::MouseFocusReason);
  enter_view();
  EXPECT_TRUE(axial().hasFocus());
  press(Qt::Key_3);
  EXPECT_EQ(bench().view.tool, Tool::Point);
  EXPECT_FLOAT_EQ(weight(), 0.9f);
}

TEST_F(KeysTest, KeysOfTheSimulationRunStepAndReset) {
  window_->panels().set_researcher(true);  // one step
  axial().setFocus();
  const std::vector<Eigen::Vector3f> seed = scene().meshes[0].mesh.positions;
  bench().apply(AddPoint{bench().view.active_mesh, bench().view.crosshair_mm + Eigen::Vector3d(16, 0, 0)});
  // Frames of few, small steps, so that the surface still moves at the second press of Space.
  bench().apply(SetSimulationParameter{find_parameter(simulation_table(), "solver"), float(Solver::Verlet)});
  bench().apply(SetSimulationParameter{find_parameter(simulation_table(), "frame_budget"), 1});
  bench().pause();
  const std::int64_t steps = bench().session().total_steps();
  press('.');
  EXPECT_EQ(bench().session().total_steps(), steps + 1);
  bench().advance_steps(20);
  ASSERT_NE(scene().meshes[0].mesh.positions, seed);
  press('r');
  bench().pause();
  EXPECT_EQ(scene().meshes[0].mesh.positions, seed);
  press(Qt::Key_Space);
  EXPECT_TRUE(bench().running());
  press(Qt::Key_Space);
  EXPECT_FALSE(bench().running());
}

TEST_F(KeysTest, KeysOfTheViewsShowFitAndCentre) {
  axial().setFocus();
  const auto is_toggled_by = [&](const bool& state, Qt::Key key, Qt::KeyboardModifiers modifiers = {}) {
    const bool before = state;
    QTest::keyClick(window_->windowHandle(), key, modifiers);
    const bool changed = state != before;
    QTest::keyClick(window_->windowHandle(), key, modifiers);
    return changed && state == before;
  };
  ViewState& view = bench().view;
  EXPECT_TRUE(is_toggled_by(view.show_meshes, Qt::Key_S));
  EXPECT_TRUE(is_toggled_by(view.show_fill, Qt::Key_S, Qt::ShiftModifier));
  EXPECT_TRUE(is_toggled_by(view.show_annotations, Qt::Key_X));
  EXPECT_TRUE(is_toggled_by(view.show_slices_3d, Qt::Key_X, Qt::ShiftModifier));
  EXPECT_TRUE(is_toggled_by(view.show_names, Qt::Key_N, Qt::ShiftModifier));
  const float opacity = view.opacity;
  press('a');
  EXPECT_LT(view.opacity, opacity);
  press('d');
  EXPECT_FLOAT_EQ(view.opacity, opacity);

  const double scale = axial().mm_per_pixel();
  const QPointF corner(60, 60), middle = axial().rect().center();
  press(Qt::Key_2);
  const Eigen::Vector3d under = axial().world_of(corner);
  drag(axial(), corner, corner + QPointF(0, 30));
  EXPECT_LT((axial().world_of(corner + QPointF(0, 30)) - under).norm(), 1e-6);  // it pans
  drag(axial(), corner, corner + QPointF(0, -60), Qt::RightButton);
  EXPECT_NE(axial().mm_per_pixel(), scale);
  QTest::keyClick(window_->windowHandle(), Qt::Key_F, Qt::ControlModifier);
  EXPECT_NEAR(axial().mm_per_pixel(), scale, 1e-9);
  press(Qt::Key_1);
  drag(axial(), corner, corner);
  EXPECT_LT((axial().pixel_of(view.crosshair_mm) - corner).manhattanLength(), 2 / axial().mm_per_pixel());
  press('c');
  EXPECT_LT((axial().pixel_of(view.crosshair_mm) - middle).manhattanLength(), 3);
  view.window = 1e6;
  QTest::keyClick(window_->windowHandle(), Qt::Key_J, Qt::ControlModifier);
  EXPECT_LT(view.window, 1e4);
  const bool panels = window_->panels().isVisible();
  press(Qt::Key_F4);
  EXPECT_NE(window_->panels().isVisible(), panels);
}

}  // namespace
}  // namespace simplexseg
