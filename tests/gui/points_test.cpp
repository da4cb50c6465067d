// SPDX-License-Identifier: Apache-2.0
// Points of the three kinds and drags of the contour: tests send events and check the session.
#include <QAction>
#include <QContextMenuEvent>
#include <QMenu>
#include <QPushButton>
#include <QTimer>
#include <QTreeWidget>

#include "gui/look/point_style.h"
#include "gui/look/theme.h"
#include "gui/panels/point_panel.h"
#include "gui/views/space_view.h"
#include "gui/window/message_bar.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class PointsTest : public PausedPhantomTest {
 protected:
  void move_mouse(const QPointF& at, Qt::KeyboardModifiers modifiers = {}) {
    mouse(axial(), QEvent::MouseMove, at, Qt::NoButton, Qt::NoButton, modifiers);
  }
  void press_key(int key, bool repeated = false) {
    QKeyEvent event(QEvent::KeyPress, key, Qt::NoModifier, {}, repeated);
    QApplication::sendEvent(&axial(), &event);
  }
  QPointF pixel(double x_mm, double y_mm) {
    return axial().pixel_of(bench().view.crosshair_mm + Eigen::Vector3d(x_mm, y_mm, 0));
  }
  /// Rightmost pixel of the contour of the sphere.
  QPointF contour_at_right() {
    axial().grabFramebuffer();  // contours are read from the last image
    double right = 0;
    for (const OutlineSegment& piece : axial().active_outline()) {
      right = std::max(right, axial().pixel_of({piece.start.x, piece.start.y, piece.start.z}).x());
    }
    for (const OutlineSegment& piece : axial().active_outline()) {
      const QPointF at = axial().pixel_of({piece.start.x, piece.start.y, piece.start.z});
      if (at.x() == right) return at;
    }
    return {};
  }
};

TEST_F(PointsTest, KeysPlaceInsideAndOutsidePointsUnderTheMouse) {
  press_key(Qt::Key_I);  // the mouse is not over the view
  EXPECT_TRUE(scene().points.empty());
  move_mouse(pixel(5, 3));
  press_key(Qt::Key_I);
  press_key(Qt::Key_I, true);  // key repeat adds no points
  move_mouse(pixel(-20, -18));
  press_key(Qt::Key_O);
  ASSERT_EQ(scene().points.size(), 2u);
  EXPECT_EQ(scene().points[0].kind, MarkKind::Inside);
  EXPECT_LT((scene().points[0].position_mm - bench().view.crosshair_mm - Eigen::Vector3d(5, 3, 0)).norm(), 1e-6);
  EXPECT_GT(scene().points[0].radius_mm, 0);
  EXPECT_EQ(scene().points[1].kind, MarkKind::Outside);
  EXPECT_EQ(scene().points[1].mesh, scene().meshes[0].id);
  EXPECT_EQ(bench().view.selected_point, scene().points[1].id);
  window_->actions()[Act::Undo]->trigger();
  ASSERT_EQ(scene().points.size(), 1u);
  EXPECT_EQ(scene().points[0].kind, MarkKind::Inside);
  window_->actions()[Act::Redo]->trigger();
  EXPECT_EQ(scene().points.size(), 2u);
}

TEST_F(PointsTest, ABoundaryPointIsDraggedAtOnce) {
  window_->actions()[Act::ToolPoint]->trigger();
  EXPECT_TRUE(window_->actions()[Act::ToolPoint]->isChecked());
  drag(axial(), pixel(-4, 0), pixel(4, 0));
  ASSERT_EQ(scene().points.size(), 1u);
  EXPECT_EQ(scene().points[0].kind, MarkKind::Boundary);
  EXPECT_NEAR(scene().points[0].position_mm.x() - bench().view.crosshair_mm.x(), 4, 1e-6);
  bench().apply(Undo{});  // placing and dragging were one step
  EXPECT_TRUE(scene().points.empty());
}

TEST_F(PointsTest, InsideAndOutsideToolsPlacePointsByAClickAndStrokesByADrag) {
  const std::pair<Act, MarkKind> tools[] = {{Act::ToolInside, MarkKind::Inside}, {Act::ToolOutside, MarkKind::Outside}};
  for (const auto& [tool, kind] : tools) {
    window_->actions()[tool]->trigger();
    EXPECT_TRUE(window_->actions()[tool]->isChecked());
    const double y = 6.0 * static_cast<int>(kind);
    drag(axial(), pixel(-4, y), pixel(-4, y));
    ASSERT_EQ(scene().points.size(), 1u);
    EXPECT_EQ(scene().points[0].kind, kind);
    EXPECT_FALSE(scene().points[0].is_stroke());
    bench().apply(Undo{});
    drag(axial(), pixel(-4, y), pixel(4, y));
    ASSERT_EQ(scene().points.size(), 1u);
    const UserPoint stroke = scene().points[0];
    EXPECT_EQ(stroke.kind, kind);
    ASSERT_TRUE(stroke.is_stroke());
    EXPECT_NEAR(stroke.position_mm.x() - bench().view.crosshair_mm.x(), -4, 1e-6);
    EXPECT_NEAR(stroke.path_mm.back().x(), 8, 1e-6);
    EXPECT_EQ(bench().session().undo_title(), std::string("add stroke"));
    // Any point tool moves it as a whole by its path, and it is deleted like every other point.
    window_->actions()[Act::ToolPoint]->trigger();
    drag(axial(), pixel(2, y), pixel(2, y + 5));
    ASSERT_EQ(scene().points.size(), 1u);
    EXPECT_LT((scene().points[0].position_mm - stroke.position_mm - Eigen::Vector3d(0, 5, 0)).norm(), 1e-6);
    EXPECT_EQ(scene().points[0].path_mm, stroke.path_mm);
    move_mouse(pixel(0, y + 5));
    window_->actions()[Act::DeletePoint]->trigger();
    EXPECT_TRUE(scene().points.empty());
    for (int undone = 0; undone < 3; ++undone) bench().apply(Undo{});
    EXPECT_TRUE(scene().points.empty());
  }
}

TEST_F(PointsTest, ABoxStartsASegmentationInOneStep) {
  window_->actions()[Act::ToolBox]->trigger();
  drag(axial(), pixel(2, 2), pixel(2, 2));
  EXPECT_EQ(scene().meshes.size(), 1u) << "a click is no box";
  drag(axial(), pixel(-22, -8), pixel(22, 8));
  ASSERT_EQ(scene().meshes.size(), 2u);
  EXPECT_LT((scene().meshes[1].seed.centre_mm - bench().view.crosshair_mm).norm(), 1e-6);
  EXPECT_EQ(scene().points.size(), 2u) << "along the longer side, and around";
  EXPECT_EQ(bench().view.tool, Tool::Crosshair);
  bench().apply(Undo{});
  EXPECT_EQ(scene().meshes.size(), 1u);
  EXPECT_TRUE(scene().points.empty());
}

TEST_F(PointsTest, AStrokeIsDrawnInItsSliceAlone) {
  const int none = count_pixels(theme::kOutside);
  window_->actions()[Act::ToolOutside]->trigger();
  drag(axial(), pixel(-12, 20), pixel(12, 20));
  move_mouse(pixel(0, -20));
  const int handle_and_line = count_pixels(theme::kOutside);
  EXPECT_GT(handle_and_line, none + 100);
  bench().set_crosshair(bench().view.crosshair_mm + 14 * axial().axes().right.cross(axial().axes().up));
  EXPECT_LE(count_pixels(theme::kOutside), none);
}

TEST_F(PointsTest, TheContextMenuOffersAllKinds) {
  const MarkKind kinds[] = {MarkKind::Boundary, MarkKind::Inside, MarkKind::Outside};  // in the order of the menu
  for (int entry = 0; entry < 3; ++entry) {
    QTimer::singleShot(0, [entry] {
      auto* menu = qobject_cast<QMenu*>(QApplication::activePopupWidget());
      ASSERT_NE(menu, nullptr);
      menu->actions()[entry]->trigger();
      menu->close();
    });
    drag(axial(), pixel(-8.0 + 8 * entry, 10), pixel(-8.0 + 8 * entry, 10), Qt::RightButton);
    ASSERT_EQ(scene().points.size(), entry + 1u);
    EXPECT_EQ(scene().points.back().kind, kinds[entry]);
  }
  QTimer::singleShot(0, [] {
    auto* menu = qobject_cast<QMenu*>(QApplication::activePopupWidget());
    ASSERT_NE(menu, nullptr);
    for (QAction* entry : menu->actions())
      if (entry->text().startsWith("Delete this")) entry->trigger();
    menu->close();
  });
  drag(axial(), pixel(0, 10), pixel(0, 10), Qt::RightButton);
  ASSERT_EQ(scene().points.size(), 2u);
  for (const UserPoint& point : scene().points) EXPECT_NE(point.kind, MarkKind::Inside);
}

TEST_F(PointsTest, OfALockedSegmentationStayAsTheyAre) {
  drag(axial(), pixel(6, 0), pixel(6, 0), Qt::LeftButton, Qt::ShiftModifier);
  move_mouse(pixel(-5, 3));
  press_key(Qt::Key_I);
  ASSERT_EQ(scene().points.size(), 2u);
  window_->actions()[Act::LockMesh]->trigger();
  const std::vector<UserPoint> before = scene().points;
  const auto unchanged = [&](const char* what) {
    SCOPED_TRACE(what);
    ASSERT_EQ(scene().points.size(), 2u);
    for (std::size_t p = 0; p < 2; ++p) {
      EXPECT_EQ(scene().points[p].position_mm, before[p].position_mm);
      EXPECT_EQ(scene().points[p].radius_mm, before[p].radius_mm);
    }
    EXPECT_TRUE(window_->messages().text().contains("locked")) << window_->messages().text().toStdString();
    window_->messages().clear();
  };
  drag(axial(), pixel(6, 0), pixel(12, 4));
  unchanged("drag");
  wheel(axial(), pixel(-5, 3), 2);
  unchanged("wheel");
  move_mouse(pixel(-5, 3));
  window_->actions()[Act::DeletePoint]->trigger();
  unchanged("Delete");
  drag(axial(), pixel(6, 0), pixel(6, 0), Qt::LeftButton, Qt::ControlModifier | Qt::ShiftModifier);
  unchanged("click that deletes");
  drag(axial(), pixel(0, 12), pixel(0, 12), Qt::LeftButton, Qt::ShiftModifier);
  unchanged("new point");
  window_->actions()[Act::ToolBrush]->trigger();
  drag(axial(), pixel(0, 12), pixel(4, 12));
  unchanged("paint");
  window_->actions()[Act::ToolPoint]->trigger();
  bench().view.show_meshes = false;  // they would hide the point
  SpaceView& space = window_->views().space();
  const QPointF handle = space.map().pixel(before[0].position_mm).value();
  drag(space, handle, handle + QPointF(30, 0));
  unchanged("drag in 3D");
  QTimer::singleShot(0, [] {
    auto* menu = qobject_cast<QMenu*>(QApplication::activePopupWidget());
    ASSERT_NE(menu, nullptr);
    for (QAction* entry : menu->actions())
      if (entry->text().contains("point here") || entry->text().startsWith("Delete this")) {
        EXPECT_TRUE(!entry->isEnabled() && entry->toolTip().contains("locked")) << entry->text().toStdString();
      }
    menu->close();
  });
  drag(axial(), pixel(6, 0), pixel(6, 0), Qt::RightButton);
  const QPushButton& erase = *window_->findChild<PointPanel*>()->findChild<QPushButton*>();
  EXPECT_FALSE(erase.isEnabled());
  EXPECT_TRUE(erase.toolTip().contains("locked")) << erase.toolTip().toStdString();
  window_->actions()[Act::LockMesh]->trigger();
  EXPECT_TRUE(erase.isEnabled());
  drag(axial(), pixel(6, 0), pixel(12, 4));
  EXPECT_GT((scene().points[0].position_mm - before[0].position_mm).norm(), 3);
}

TEST_F(PointsTest, ThePanelNamesTheKinds) {
  for (const MarkKind kind : {MarkKind::Boundary, MarkKind::Inside, MarkKind::Outside}) {
    bench().apply(AddPoint{bench().view.active_mesh,
                           bench().view.crosshair_mm + Eigen::Vector3d(5.0 * static_cast<int>(kind), 0, 0), kind});
  }
  auto* list = window_->findChild<PointPanel*>()->findChild<QTreeWidget*>();
  ASSERT_EQ(list->topLevelItemCount(), 3);
  EXPECT_EQ(list->topLevelItem(0)->text(1), "Boundary");
  EXPECT_EQ(list->topLevelItem(1)->text(1), "Inside");
  EXPECT_EQ(list->topLevelItem(2)->text(1), "Outside");
  list->setCurrentItem(list->topLevelItem(1));
  EXPECT_EQ(bench().view.selected_point, scene().points[1].id);
  window_->actions()[Act::DeletePoint]->trigger();
  ASSERT_EQ(scene().points.size(), 2u);
  EXPECT_EQ(scene().points[1].kind, MarkKind::Outside);
}

TEST_F(PointsTest, KindsAndTheirBallsAreDrawn) {
  window_->actions()[Act::Annotations]->trigger();  // hides the crosshair
  EXPECT_EQ(count_pixels(theme::kInside), 0);
  EXPECT_EQ(count_pixels(theme::kOutside), 0);
  const Eigen::Vector3d at = bench().view.crosshair_mm;
  bench().apply(AddPoint{bench().view.active_mesh, at, MarkKind::Inside, 8});
  EXPECT_GT(count_pixels(theme::kInside), 20);
  EXPECT_EQ(count_pixels(theme::kOutside), 0);
  const auto ball_at = [&](double radius_mm) {
    const QImage picture = axial().grabFramebuffer();
    const QPointF place = axial().pixel_of(at + Eigen::Vector3d(0, radius_mm, 0)) * axial().devicePixelRatio();
    int most = -255;  // a line may lie between two pixels
    for (int dy = -1; dy <= 1; ++dy) {
      const QColor colour = picture.pixelColor(place.toPoint() + QPoint(0, dy));
      most = std::max(most, colour.red() - colour.blue());  // the mesh is orange
    }
    return most;
  };
  EXPECT_GT(ball_at(8), 60);
  EXPECT_LT(ball_at(6), 20);
  bench().view.crosshair_mm.z() += 5;  // the slice cuts the ball 5 mm off its centre
  bench().view_edited();
  EXPECT_GT(ball_at(std::sqrt(8.0 * 8 - 5 * 5)), 60);
  bench().apply(AddPoint{bench().view.active_mesh, at + Eigen::Vector3d(0, 20, 5), MarkKind::Outside});
  EXPECT_GT(count_pixels(theme::kOutside), 20);
}

TEST_F(PointsTest, AnOutsidePointBeyondTheVolumeIsRefusedWithAMessage) {
  for (int n = 0; n < 30; ++n) axial().zoom_about(axial().rect().center(), 1.1);
  move_mouse(QPointF(2, 2));
  press_key(Qt::Key_O);
  EXPECT_TRUE(scene().points.empty());
  EXPECT_TRUE(window_->messages().isVisible());
  EXPECT_TRUE(window_->messages().text().contains("outside point")) << window_->messages().text().toStdString();
}

TEST_F(PointsTest, DraggingTheContourAddsABoundaryPoint) {
  const Eigen::Vector3d crosshair = bench().view.crosshair_mm;
  const QPointF contour = contour_at_right();
  ASSERT_GT(contour.x(), pixel(10, 0).x());
  move_mouse(contour + QPointF(2, 0));
  EXPECT_EQ(axial().cursor().shape(), Qt::OpenHandCursor);
  drag(axial(), contour + QPointF(2, 0), contour + QPointF(42, 0));
  ASSERT_EQ(scene().points.size(), 1u);
  EXPECT_EQ(scene().points[0].kind, MarkKind::Boundary);
  EXPECT_LT((scene().points[0].position_mm - axial().world_of(contour + QPointF(42, 0))).norm(), 1e-6);
  EXPECT_EQ(bench().view.crosshair_mm, crosshair);
  bench().apply(Undo{});
  EXPECT_TRUE(scene().points.empty());  // one step
  EXPECT_FALSE(bench().session().can_undo());
}

TEST_F(PointsTest, ADragBesideTheContourOrAClickOnItMovesTheCrosshair) {
  const QPointF contour = contour_at_right();
  move_mouse(contour - QPointF(7, 0));
  EXPECT_EQ(axial().cursor().shape(), Qt::ArrowCursor);
  drag(axial(), contour - QPointF(7, 0), contour - QPointF(40, 0));
  EXPECT_TRUE(scene().points.empty());
  EXPECT_LT((bench().view.crosshair_mm - axial().world_of(contour - QPointF(40, 0))).norm(), 0.9);
  const QPointF again = contour_at_right();
  drag(axial(), again, again);
  EXPECT_TRUE(scene().points.empty());
  EXPECT_LT((bench().view.crosshair_mm - axial().world_of(again)).norm(), 0.9);
  // A hidden contour cannot be dragged.
  window_->actions()[Act::ShowMeshes]->trigger();
  axial().grabFramebuffer();
  drag(axial(), again, again - QPointF(30, 0));
  EXPECT_TRUE(scene().points.empty());
  EXPECT_LT((bench().view.crosshair_mm - axial().world_of(again - QPointF(30, 0))).norm(), 0.9);
}

TEST_F(PointsTest, ADoubleClickDoesNotMoveTheCrosshair) {
  const Eigen::Vector3d before = bench().view.crosshair_mm;
  const QPointF at = pixel(-20, -20);
  drag(axial(), at, at);
  mouse(axial(), QEvent::MouseButtonDblClick, at, Qt::LeftButton, Qt::LeftButton);
  mouse(axial(), QEvent::MouseButtonRelease, at, Qt::LeftButton, Qt::NoButton);
  EXPECT_TRUE(window_->views().space().isHidden());
  EXPECT_EQ(bench().view.crosshair_mm, before);
  // After a drag that ended there, a click is another gesture.
  mouse(axial(), QEvent::MouseButtonDblClick, at, Qt::LeftButton, Qt::LeftButton);
  drag(axial(), pixel(0, 0), pixel(8, 0));
  EXPECT_NEAR(bench().view.crosshair_mm.x() - before.x(), 8, 0.51);
}

TEST_F(PointsTest, APointRestoredByUndoUnderTheMouseIsDeleted) {
  const Eigen::Vector3d at = bench().view.crosshair_mm + Eigen::Vector3d(5, 5, 0);
  bench().apply(AddPoint{bench().view.active_mesh, at, MarkKind::Inside, 3});
  bench().apply(AddPoint{bench().view.active_mesh, at - Eigen::Vector3d(15, 0, 0), MarkKind::Inside, 3});
  move_mouse(axial().pixel_of(at));
  window_->actions()[Act::DeletePoint]->trigger();
  ASSERT_EQ(scene().points.size(), 1u);
  window_->actions()[Act::Undo]->trigger();
  ASSERT_EQ(scene().points.size(), 2u);
  window_->actions()[Act::DeletePoint]->trigger();  // the mouse has not moved
  ASSERT_EQ(scene().points.size(), 1u);
  EXPECT_NE(scene().points[0].position_mm, at);
}

TEST_F(PointsTest, ControlShiftAndAClickDeleteAPoint) {
  const Eigen::Vector3d at = bench().view.crosshair_mm + Eigen::Vector3d(5, 5, 0);
  bench().apply(AddPoint{bench().view.active_mesh, at, MarkKind::Inside, 3});
  drag(axial(), axial().pixel_of(at), axial().pixel_of(at), Qt::LeftButton, Qt::ControlModifier | Qt::ShiftModifier);
  EXPECT_TRUE(scene().points.empty());
}

}  // namespace
}  // namespace simplexseg
