// SPDX-License-Identifier: Apache-2.0
// Layout of three neighbouring slices: tests send events and check the session and the pictures.
#include <QAction>
#include <QMenu>
#include <QSettings>
#include <cmath>

#include "gui/look/theme.h"
#include "gui/views/space_view.h"
#include "gui/window/view_layout_menu.h"
#include "gui/window/window_memory.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class NeighbourSlicesTest : public PausedPhantomTest {
 protected:
  void choose(const QString& title) {
    choose_entry({window_->findChild<QMenu*>("view_layout_menu"), distance_menu()}, title);
  }
  QMenu* distance_menu() { return window_->findChild<QMenu*>("view_layout_menu")->findChild<QMenu*>(); }
  SliceView& view(int n) { return *qobject_cast<SliceView*>(window_->views().every()[static_cast<std::size_t>(n)]); }
  SliceView& previous() { return view(4); }
  SliceView& next() { return view(5); }
  static QPointF pixel(SliceView& view, double right_mm, double up_mm) {
    return view.pixel_of(view.through_mm() + right_mm * view.axes().right + up_mm * view.axes().up);
  }
};

TEST_F(NeighbourSlicesTest, ShowThePreviousCurrentAndNextSlice) {
  choose("Axial: previous, current and next slice");
  const double here = bench().view.crosshair_mm.z();
  for (const int n : {0, 4, 5}) EXPECT_TRUE(view(n).isVisible()) << n;
  for (const int n : {1, 2}) EXPECT_FALSE(view(n).isVisible()) << n;
  EXPECT_FALSE(window_->views().space().isVisible());
  EXPECT_LT(previous().x() + 1, axial().mapTo(&window_->views(), QPoint(0, 0)).x()) << "from left to right";
  EXPECT_GT(next().x(), axial().mapTo(&window_->views(), QPoint(0, 0)).x());
  EXPECT_NEAR(previous().slice_mm(), here - 1, 1e-9);
  EXPECT_NEAR(next().slice_mm(), here + 1, 1e-9);
  choose("5 slices");
  EXPECT_NEAR(previous().slice_mm(), here - 5, 1e-9);
  EXPECT_NEAR(next().slice_mm(), here + 5, 1e-9);
  wheel(next(), QPointF(40, 40), 2);  // all three follow
  EXPECT_NEAR(std::abs(bench().view.crosshair_mm.z() - here), 2, 1e-9);
  EXPECT_NEAR(previous().slice_mm(), bench().view.crosshair_mm.z() - 5, 1e-9);
  const QImage first = previous().grabFramebuffer(), middle = axial().grabFramebuffer();
  EXPECT_NE(first, middle);
  choose("Coronal: previous, current and next slice");
  EXPECT_TRUE(view(2).isVisible());
  EXPECT_EQ(previous().orientation(), Orientation::Coronal);
  EXPECT_NEAR(previous().slice_mm(), bench().view.crosshair_mm.y() - 5, 1e-9);
  EXPECT_EQ(previous().objectName(), "Coronal, previous slice");
  if (const char* folder = std::getenv("SIMPLEXSEG_PICTURES"))
    window_->grab().save(QString(folder) + "/neighbours.png");
  choose("Four views");
  for (const int n : {0, 1, 2}) EXPECT_TRUE(view(n).isVisible());
  EXPECT_FALSE(previous().isVisible());
}

TEST_F(NeighbourSlicesTest, AClickKeepsTheSliceAndADrawingLiesInItsOwn) {
  choose("Axial: previous, current and next slice");
  choose("3 slices");
  const Eigen::Vector3d here = bench().view.crosshair_mm;
  drag(next(), pixel(next(), 8, 4), pixel(next(), 8, 4));
  EXPECT_NEAR(bench().view.crosshair_mm.z(), here.z(), 1e-9) << "the crosshair stays in its slice";
  EXPECT_GT((bench().view.crosshair_mm - here).norm(), 5);
  drag(next(), pixel(next(), 20, 20), pixel(next(), 22, 22));  // many movements
  EXPECT_NEAR(bench().view.crosshair_mm.z(), here.z(), 1e-9);
  bench().set_crosshair(here);
  const auto draw = [&](SliceView& in, double up_mm) {
    window_->actions()[Act::ToolInside]->trigger();
    drag(in, pixel(in, -4, up_mm), pixel(in, 5, up_mm));
    return scene().points.back().position_mm.z();
  };
  EXPECT_NEAR(draw(previous(), 3), here.z() - 3, 1e-9);
  EXPECT_NEAR(draw(next(), 9), here.z() + 3, 1e-9);
  EXPECT_NEAR(draw(axial(), -3), here.z(), 1e-9);
  ASSERT_EQ(scene().points.size(), 3u);
  const Eigen::Vector3d before = scene().points[0].position_mm;
  drag(previous(), previous().pixel_of(before), pixel(previous(), 0, -12));
  EXPECT_NEAR(scene().points[0].position_mm.z(), before.z(), 1e-9) << "a handle is moved in its slice";
  EXPECT_GT((scene().points[0].position_mm - before).norm(), 4);
}

TEST_F(NeighbourSlicesTest, TheContourIsDrawnAndPulledInEach) {
  choose("Axial: previous, current and next slice");
  choose("10 slices");
  for (SliceView* view : {&previous(), &next(), &axial()}) {
    view->grabFramebuffer();
    ASSERT_FALSE(view->active_outline().empty());
    const Eigen::Vector3d centre = scene().meshes[0].seed.centre_mm;
    double farthest = 0;
    for (const OutlineSegment& piece : view->active_outline())
      farthest = std::max<double>(farthest, std::hypot(piece.start.x - centre.x(), piece.start.y - centre.y()));
    const double off = view->slice_mm() - centre.z();
    EXPECT_NEAR(farthest, std::sqrt(144 - off * off), 0.7) << "section of the sphere of 12 mm";
  }
  const OutlineSegment piece = next().active_outline()[0];
  const QPointF on = next().pixel_of({piece.start.x, piece.start.y, piece.start.z});
  drag(next(), on, on + QPointF(30, 10));
  ASSERT_EQ(scene().points.size(), 1u);
  EXPECT_EQ(scene().points[0].kind, MarkKind::Boundary);
  EXPECT_NEAR(scene().points[0].position_mm.z(), next().slice_mm(), 1e-6);
}

TEST_F(NeighbourSlicesTest, HaveOneZoomAndCanBeMaximised) {
  choose("Sagittal: previous, current and next slice");
  const double before = view(1).mm_per_pixel();
  wheel(previous(), QPointF(50, 60), 3, Qt::ControlModifier);
  EXPECT_NE(previous().mm_per_pixel(), before);
  EXPECT_EQ(view(1).mm_per_pixel(), previous().mm_per_pixel());
  EXPECT_EQ(next().mm_per_pixel(), previous().mm_per_pixel());
  mouse(next(), QEvent::MouseButtonDblClick, QPointF(40, 40), Qt::LeftButton, Qt::LeftButton);
  EXPECT_EQ(window_->views().shown_alone(), 5);
  EXPECT_FALSE(previous().isVisible());
  window_->views().show_alone(-1);
  EXPECT_TRUE(previous().isVisible());
  bench().set_crosshair({1e6, 0, 0});  // the last slice has no next one
  EXPECT_NO_THROW(next().grabFramebuffer());
  drag(next(), QPointF(60, 60), QPointF(60, 60));
}

TEST_F(NeighbourSlicesTest, AreRemembered) {
  QSettings::setPath(QSettings::IniFormat, QSettings::UserScope, folder_.path());
  {
    WindowMemory memory(*window_);
    choose("Coronal: previous, current and next slice");
    choose("3 slices");
  }
  window_->views().set_layout(ViewLayout::Four);
  window_->views().set_neighbour_step(1);
  {
    WindowMemory memory(*window_);
    EXPECT_EQ(window_->views().view_layout(), ViewLayout::Neighbours);
    EXPECT_EQ(window_->views().main_view(), 2);
    EXPECT_EQ(window_->views().neighbour_step(), 3);
    choose("Four views");
  }
  WindowMemory memory(*window_);
  EXPECT_EQ(window_->views().view_layout(), ViewLayout::Four);
}

}  // namespace
}  // namespace simplexseg
