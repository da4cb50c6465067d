// SPDX-License-Identifier: Apache-2.0
// Messages cover the views without moving them, and disappear when they are no longer true.
#include "gui/window/message_bar.h"

#include "gui/window/file_actions.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class MessagesTest : public PausedPhantomTest {
 protected:
  void fail() { EXPECT_FALSE(bench().apply(AddMesh{"far", Seed{{9000, 0, 0}, 5}, {}, 0})); }
};

TEST_F(MessagesTest, AMessageMovesNoView) {
  const QRect before(axial().mapTo(window_.get(), QPoint()), axial().size());
  const Eigen::Vector3d under = axial().world_of(QPointF(100, 100));
  bench().notify(Severity::Warning, "a warning");
  QApplication::processEvents();
  ASSERT_TRUE(window_->messages().isVisible());
  EXPECT_EQ(QRect(axial().mapTo(window_.get(), QPoint()), axial().size()), before);
  EXPECT_EQ(axial().world_of(QPointF(100, 100)), under);
  window_->messages().clear();
  QApplication::processEvents();
  EXPECT_EQ(QRect(axial().mapTo(window_.get(), QPoint()), axial().size()), before);
}

TEST_F(MessagesTest, AMessageDuringADragLeavesThePointUnderTheMouse) {
  const Eigen::Vector3d start = bench().view.crosshair_mm + Eigen::Vector3d(15, 0, 0);
  const QPointF from = axial().pixel_of(start), to = from + QPointF(30, 0);
  mouse(axial(), QEvent::MouseButtonPress, from, Qt::LeftButton, Qt::LeftButton, Qt::ShiftModifier);
  bench().notify(Severity::Warning, "a warning");
  QApplication::processEvents();
  mouse(axial(), QEvent::MouseMove, to, Qt::NoButton, Qt::LeftButton, Qt::ShiftModifier);
  mouse(axial(), QEvent::MouseButtonRelease, to, Qt::LeftButton, Qt::NoButton, Qt::ShiftModifier);
  ASSERT_EQ(scene().points.size(), 1u);
  const Eigen::Vector3d moved = scene().points[0].position_mm - start;
  EXPECT_NEAR(moved.x(), 30 * axial().mm_per_pixel(), 1e-6);
  EXPECT_NEAR(moved.y(), 0, 1e-6);
}

TEST_F(MessagesTest, AFailureDisappearsAfterALaterSuccess) {
  fail();
  ASSERT_TRUE(window_->messages().isVisible());
  ASSERT_TRUE(bench().apply(AddMesh{"near", Seed{bench().view.crosshair_mm, 5}, {}, 0}));
  EXPECT_FALSE(window_->messages().isVisible());
  // A warning describes a state, and stays.
  bench().notify(Severity::Warning, "a warning");
  ASSERT_TRUE(bench().apply(Undo{}));
  EXPECT_TRUE(window_->messages().isVisible());
}

}  // namespace
}  // namespace simplexseg
