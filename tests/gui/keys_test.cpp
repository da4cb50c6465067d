// SPDX-License-Identifier: Apache-2.0
// Where keys go: to the views, but while something is being typed.
#include <QAction>
#include <QDoubleSpinBox>
#include <QEnterEvent>
#include <QLineEdit>
#include <QTest>

#include "gui/panels/force_panel.h"
#include "gui/panels/parameter_row.h"
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
  /// As a user does: a click into the number, all of it chosen, a new one typed.
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

TEST_F(KeysTest, AfterReturnKeysAreForTheViewsAgain) {
  type("0.7");
  press(Qt::Key_Return);
  EXPECT_FLOAT_EQ(weight(), 0.7f);
  press(Qt::Key_4);
  EXPECT_FLOAT_EQ(weight(), 0.7f);
  EXPECT_EQ(bench().view.tool, Tool::Seed);
  press(Qt::Key_Space);
  EXPECT_TRUE(bench().running());
}

TEST_F(KeysTest, EscapeTakesBackWhatWasTyped) {
  type("3");
  press(Qt::Key_Escape);
  EXPECT_EQ(number_->text(), "0.50");
  press(Qt::Key_2);
  EXPECT_EQ(bench().view.tool, Tool::ZoomPan);
  EXPECT_FLOAT_EQ(weight(), 0.5f);
}

TEST_F(KeysTest, ATypedValueIsAppliedWhenTheFocusLeaves) {
  type("0.8");
  EXPECT_FLOAT_EQ(weight(), 0.5f);
  enter_view();  // passing over a view does not take the keys from who types
  EXPECT_TRUE(number_->hasFocus());
  QTest::mouseClick(&axial(), Qt::LeftButton, {}, QPoint(60, 60));
  EXPECT_FLOAT_EQ(weight(), 0.8f);
  EXPECT_TRUE(axial().hasFocus());
}

TEST_F(KeysTest, ANumberThatIsNotBeingTypedLosesTheKeysToTheViewUnderTheMouse) {
  type("0.9");
  press(Qt::Key_Return);
  number_->setFocus(Qt::MouseFocusReason);
  enter_view();
  EXPECT_TRUE(axial().hasFocus());
  press(Qt::Key_3);
  EXPECT_EQ(bench().view.tool, Tool::Point);
  EXPECT_FLOAT_EQ(weight(), 0.9f);
}

}  // namespace
}  // namespace simplexseg
