// SPDX-License-Identifier: Apache-2.0
// Lassos of marks: tests send events and check the session, the list of points and the picture.
#include <QAction>
#include <QTreeWidget>
#include <cmath>

#include "gui/look/theme.h"
#include "gui/panels/point_panel.h"
#include "gui/window/name_popup.h"
#include "gui/workbench/naming.h"
#include "session/lasso.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class LassoTest : public PausedPhantomTest {
 protected:
  std::vector<QPointF> circle(double radius_mm) {
    std::vector<QPointF> path;
    for (int n = 0; n <= 40; ++n)
      path.push_back(pixel(radius_mm * std::cos(n * M_PI / 20), radius_mm * std::sin(n * M_PI / 20)));
    return path;
  }
  void draw_lasso(Act tool, double radius_mm) {
    if (!bench().view.lasso) press(Act::Lasso);
    press(tool);
    drag(axial(), circle(radius_mm));
  }
  QTreeWidget& list() { return *window_->findChild<PointPanel*>()->findChild<QTreeWidget*>(); }
};

TEST_F(LassoTest, OfMarksIsOneActionAndOneRow) {
  draw_lasso(Act::ToolInside, 15);
  EXPECT_EQ(bench().session().undo_title(), std::string("add inside lasso"));
  ASSERT_EQ(scene().points.size(), 1u);
  const UserPoint lasso = scene().points[0];
  ASSERT_TRUE(lasso.is_lasso());
  ASSERT_GE(stroke_count(lasso), 3);
  ASSERT_EQ(list().topLevelItemCount(), 1);
  EXPECT_EQ(list().topLevelItem(0)->toolTip(1), QString("Lasso, inside, %1 strokes").arg(stroke_count(lasso)));
  EXPECT_EQ(list().topLevelItem(0)->text(1), QString("Lasso, inside\n%1 strokes").arg(stroke_count(lasso)));
  EXPECT_EQ(bench().view.selected_point, lasso.id);
  press(Act::Undo);
  EXPECT_TRUE(scene().points.empty());
  EXPECT_EQ(list().topLevelItemCount(), 0);
  drag(axial(), pixel(0, 0), pixel(0, 0));
  ASSERT_EQ(scene().points.size(), 1u) << "a click is a point";
  EXPECT_FALSE(scene().points[0].is_stroke());
  press(Act::Undo);
  draw_lasso(Act::ToolOutside, 8);
  EXPECT_EQ(bench().session().undo_title(), std::string("add outside lasso"));
  EXPECT_TRUE(list().topLevelItem(0)->text(1).startsWith("Lasso, outside\n"));
}

TEST_F(LassoTest, IsMovedAndDeletedAsAWhole) {
  draw_lasso(Act::ToolInside, 15);
  const UserPoint lasso = scene().points.at(0);
  press(Act::ToolPoint);
  drag(axial(), pixel(-15, 0), pixel(-15, 4));  // by its contour, opposite the handle
  ASSERT_EQ(scene().points.size(), 1u);
  EXPECT_LT((scene().points[0].position_mm - lasso.position_mm - Eigen::Vector3d(0, 4, 0)).norm(), 1e-6);
  EXPECT_EQ(scene().points[0].path_mm, lasso.path_mm);
  EXPECT_EQ(bench().session().undo_title(), std::string("move point"));
  press(Act::Undo);
  EXPECT_EQ(scene().points[0].position_mm, lasso.position_mm);
  drag(axial(), axial().pixel_of(lasso.position_mm), pixel(17, 3));  // by its handle
  EXPECT_GT((scene().points[0].position_mm - lasso.position_mm).norm(), 2);
  press(Act::Undo);
  mouse(axial(), QEvent::MouseMove, pixel(0, 15), Qt::NoButton, Qt::NoButton);
  EXPECT_EQ(bench().view.hovered_point, lasso.id);
  press(Act::DeletePoint);
  EXPECT_TRUE(scene().points.empty());
  press(Act::Undo);
  ASSERT_EQ(scene().points.size(), 1u);
  EXPECT_EQ(stroke_count(scene().points[0]), stroke_count(lasso));
}

TEST_F(LassoTest, TheWheelOverItChangesTheSlice) {
  draw_lasso(Act::ToolInside, 15);
  const double before = bench().view.crosshair_mm.z();
  wheel(axial(), pixel(0, 15), 1);
  EXPECT_NEAR(std::abs(bench().view.crosshair_mm.z() - before), 1, 1e-6);
  EXPECT_EQ(scene().points[0].radius_mm, 0);
}

TEST_F(LassoTest, IsDrawnAsItsContourInItsSlice) {
  press(Act::Annotations);
  const int before = count_pixels(theme::kInside);
  draw_lasso(Act::ToolInside, 22);
  bench().view.selected_point = 0;
  mouse(axial(), QEvent::MouseMove, pixel(28, 28), Qt::NoButton, Qt::NoButton);
  const int drawn = count_pixels(theme::kInside);
  EXPECT_GT(drawn, before + 100);
  if (const char* folder = std::getenv("SIMPLEXSEG_PICTURES")) window_->grab().save(QString(folder) + "/lasso.png");
  bench().set_crosshair(bench().view.crosshair_mm + Eigen::Vector3d(0, 0, 13));
  EXPECT_LT(count_pixels(theme::kInside), before + 5);
}

TEST_F(LassoTest, ABoxToolWithLassoStartsASegmentation) {
  press(Act::ToolBox);
  press(Act::Lasso);
  drag(axial(), pixel(2, 2), pixel(2, 2));
  EXPECT_EQ(scene().meshes.size(), 1u) << "a click is no contour";
  drag(axial(), circle(14));
  ASSERT_EQ(scene().meshes.size(), 2u);
  EXPECT_EQ(bench().session().undo_title(), std::string("add segmentation"));
  EXPECT_LT((scene().meshes[1].seed.centre_mm - bench().view.crosshair_mm).norm(), 1);
  ASSERT_EQ(scene().points.size(), 1u);
  EXPECT_TRUE(scene().points[0].is_lasso());
  EXPECT_EQ(scene().points[0].mesh, scene().meshes[1].id);
  EXPECT_EQ(bench().view.tool, Tool::Crosshair);
  press(Act::Undo);
  EXPECT_EQ(scene().meshes.size(), 1u);
  EXPECT_TRUE(scene().points.empty());
}

TEST_F(LassoTest, OfInsideStartsASegmentationIfThereIsNone) {
  bench().apply(DeleteMesh{scene().meshes[0].id});
  ASSERT_TRUE(choose_label_preset(bench(), "abdomen"));
  draw_lasso(Act::ToolInside, 14);
  ASSERT_EQ(scene().meshes.size(), 1u);
  ASSERT_EQ(scene().points.size(), 1u);
  QApplication::processEvents();
  EXPECT_TRUE(window_->findChild<NamePopup*>("name_popup")->isVisible()) << "as after a seed or a box";
  press(Act::Undo);
  EXPECT_FALSE(window_->actions()[Act::ToolOutside]->isEnabled());
  draw_lasso(Act::ToolOutside, 14);
  EXPECT_TRUE(scene().meshes.empty()) << "an outside lasso needs a segmentation";
}

}  // namespace
}  // namespace simplexseg
