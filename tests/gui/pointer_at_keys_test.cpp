// SPDX-License-Identifier: Apache-2.0
// Marks made by keys lie where the pointer was at the key press, even if movements were dropped during long frames.
#include <QAbstractEventDispatcher>
#include <QAction>
#include <QKeyEvent>
#include <QWindow>
#include <cstdint>
#include <cstring>

#include "window_fixture.h"

namespace simplexseg {
namespace {

class PointerAtKeysTest : public PausedPhantomTest {
 protected:
  QPoint in_window(const SliceView& view, const QPointF& at) const { return view.mapTo(window_.get(), at).toPoint(); }
  /// Delivers a movement of the pointer.
  void move(const SliceView& view, const QPointF& at) {
    const QPointF place = in_window(view, at);
    QMouseEvent event(QEvent::MouseMove, place, window_->mapToGlobal(place), Qt::NoButton, Qt::NoButton, {});
    QApplication::sendEvent(window_->windowHandle(), &event);
  }
  /// Delivers a key press as X11 reports it: with the position of the pointer, which Qt does not pass on.
  void press(int key, const SliceView& view, const QPointF& at, QEvent::Type type = QEvent::KeyPress,
             Qt::KeyboardModifiers modifiers = {}) {
    const QPoint place = in_window(view, at) * window_->devicePixelRatio();
    ++time_ms_;
    unsigned char bytes[32]{};
    bytes[0] = 2;  // KeyPress
    std::memcpy(bytes + 4, &time_ms_, 4);
    const auto x = static_cast<std::int16_t>(place.x()), y = static_cast<std::int16_t>(place.y());
    std::memcpy(bytes + 24, &x, 2);
    std::memcpy(bytes + 26, &y, 2);
    qintptr result = 0;
    QAbstractEventDispatcher::instance()->filterNativeEvent("xcb_generic_event_t", bytes, &result);
    QKeyEvent event(type, key, modifiers);
    event.setTimestamp(time_ms_);
    QApplication::sendEvent(window_->windowHandle(), &event);
  }
  QPointF place(int n) { return QPointF(axial().rect().center()) + QPointF(5 * n - 50, 3 * n - 30); }

  std::uint32_t time_ms_ = 1000;
};

TEST_F(PointerAtKeysTest, TwentyMarksLieAtTwentyPlaces) {
  axial().setFocus();
  move(axial(), {20, 20});
  for (int n = 0; n < 20; ++n) press(n % 2 ? Qt::Key_O : Qt::Key_I, axial(), place(n));  // no movement is delivered
  ASSERT_EQ(scene().points.size(), 20u);
  for (int n = 0; n < 20; ++n) {
    const QPointF at = axial().pixel_of(scene().points[static_cast<std::size_t>(n)].position_mm);
    EXPECT_LT((at - place(n)).manhattanLength(), 1.5) << n;
    EXPECT_EQ(scene().points[static_cast<std::size_t>(n)].kind, n % 2 ? MarkKind::Outside : MarkKind::Inside);
  }
}

TEST_F(PointerAtKeysTest, AMarkLiesInTheViewUnderThePointer) {
  SliceView& sagittal = window_->views().slice(1);
  axial().setFocus();
  move(axial(), {20, 20});
  const QPointF at = QPointF(sagittal.rect().center()) + QPointF(15, -12);
  press(Qt::Key_I, sagittal, at);
  ASSERT_EQ(scene().points.size(), 1u);
  EXPECT_LT((sagittal.pixel_of(scene().points[0].position_mm) - at).manhattanLength(), 1.5);
  EXPECT_EQ(scene().points[0].position_mm[0], sagittal.slice_mm());
}

TEST_F(PointerAtKeysTest, APointAtTheCrosshairFollowsThePointerWhileShiftIsHeld) {
  axial().setFocus();
  move(axial(), {20, 20});
  press(Qt::Key_B, axial(), place(3), QEvent::ShortcutOverride, Qt::ShiftModifier);
  window_->actions()[Act::BoundaryHere]->trigger();
  ASSERT_EQ(scene().points.size(), 1u);
  const double voxel = 1 / axial().mm_per_pixel();  // the crosshair lies on a voxel centre
  EXPECT_LT((axial().pixel_of(scene().points[0].position_mm) - place(3)).manhattanLength(), voxel + 1.5);
}

TEST_F(PointerAtKeysTest, AnUnmovedPointerLeavesTheCrosshair) {
  axial().setFocus();
  move(axial(), place(2));
  const Eigen::Vector3d crosshair = bench().view.crosshair_mm;
  press(Qt::Key_B, axial(), place(2), QEvent::ShortcutOverride, Qt::ShiftModifier);
  EXPECT_EQ(bench().view.crosshair_mm, crosshair);
}

}  // namespace
}  // namespace simplexseg
