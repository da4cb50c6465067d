// SPDX-License-Identifier: Apache-2.0
// Brush and eraser: tests send events and check the session and the picture.
#include <QAction>
#include <QInputDialog>
#include <QMenu>
#include <QTreeWidget>
#include <cmath>

#include "gui/look/theme.h"
#include "gui/panels/point_panel.h"
#include "gui/views/paint_outline.h"
#include "gui/window/message_bar.h"
#include "image/rasterise.h"
#include "session/label_map.h"
#include "session/paint.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class PaintTest : public PausedPhantomTest {
 protected:
  int label_at(const Eigen::Vector3d& offset_mm) {
    const Volume& volume = bench().session().volume();
    const LabelMap map = make_label_map(scene(), volume.geometry());
    const Eigen::Vector3d v = volume.geometry().index_from_world() * (bench().view.crosshair_mm + offset_mm);
    return map.labels.voxels<std::uint8_t>()[volume.offset(
        static_cast<int>(std::lround(v[0])), static_cast<int>(std::lround(v[1])), static_cast<int>(std::lround(v[2])))];
  }
};

TEST_F(PaintTest, ADragPaintsVoxelsAndTheEraserRemovesThem) {
  press(Act::ToolBrush);
  EXPECT_TRUE(window_->actions()[Act::ToolBrush]->isChecked());
  EXPECT_EQ(label_at({24, 20, 0}), 0);
  drag(axial(), pixel(20, 20), pixel(26, 20));
  ASSERT_EQ(scene().points.size(), 1u);
  EXPECT_TRUE(scene().points[0].is_paint());
  EXPECT_EQ(bench().session().undo_title(), std::string("paint"));
  EXPECT_EQ(label_at({24, 20, 0}), 1);
  EXPECT_EQ(label_at({24, 20, 2}), 0) << "a disc paints one slice";
  press(Act::ToolEraser);
  drag(axial(), pixel(24, 20), pixel(24, 20));
  EXPECT_EQ(label_at({24, 20, 0}), 0);
  EXPECT_EQ(label_at({18, 20, 0}), 1);
  EXPECT_EQ(bench().session().undo_title(), std::string("erase"));
  press(Act::Undo);
  EXPECT_EQ(label_at({24, 20, 0}), 1);
  press(Act::Undo);
  EXPECT_EQ(label_at({24, 20, 0}), 0);
}

TEST_F(PaintTest, TheBrushIsABallInThreeDimensions) {
  press(Act::ToolBrush);
  press(Act::Brush3d);
  EXPECT_TRUE(bench().view.brush_3d);
  drag(axial(), pixel(24, 20), pixel(24, 20));
  EXPECT_EQ(label_at({24, 20, 2}), 1);
  EXPECT_EQ(label_at({24, 20, -2}), 1);
}

TEST_F(PaintTest, ShiftAndTheWheelChangeItsSize) {
  press(Act::ToolBrush);
  const double before = bench().view.brush_mm, slice = bench().view.crosshair_mm.z();
  wheel(axial(), pixel(5, 5), 3, Qt::ShiftModifier);
  EXPECT_GT(bench().view.brush_mm, 1.3 * before);
  wheel(axial(), pixel(5, 5), -3, Qt::ShiftModifier);
  EXPECT_NEAR(bench().view.brush_mm, before, 0.3 * before);
  EXPECT_EQ(bench().view.crosshair_mm.z(), slice);
  wheel(axial(), pixel(5, 5), 1, Qt::NoModifier);
  EXPECT_NE(bench().view.crosshair_mm.z(), slice) << "the wheel alone changes the slice";
  for (int n = 0; n < 100; ++n) wheel(axial(), pixel(5, 5), -1, Qt::ShiftModifier);
  EXPECT_GE(bench().view.brush_mm, 0.4 * bench().session().volume().geometry().spacing_mm.minCoeff());
}

TEST_F(PaintTest, IsOutlinedInItsSliceAndListed) {
  press(Act::ToolBrush);
  const int none = count_pixels(theme::kInside);
  drag(axial(), pixel(14, 20), pixel(26, 20));
  mouse(axial(), QEvent::MouseMove, pixel(-25, -25), Qt::NoButton, Qt::NoButton);
  EXPECT_GT(count_pixels(theme::kInside), none + 60);
  const auto* list = window_->findChild<PointPanel*>()->findChild<QTreeWidget*>();
  ASSERT_EQ(list->topLevelItemCount(), 1);
  EXPECT_EQ(list->topLevelItem(0)->text(1), "Paint");
  const int painted = count_pixels(theme::kInside);
  bench().set_crosshair(bench().view.crosshair_mm + Eigen::Vector3d(0, 0, 3));
  EXPECT_LT(count_pixels(theme::kInside), painted - 60) << "only the brush remains";
}

TEST_F(PaintTest, ALassoPaintsWhatItEncloses) {
  press(Act::ToolBrush);
  press(Act::Lasso);
  const std::vector<QPointF> around{pixel(18, 18), pixel(28, 18), pixel(28, 26), pixel(18, 26), pixel(18, 19)};
  drag(axial(), around);
  ASSERT_EQ(scene().points.size(), 1u);
  EXPECT_EQ(scene().points[0].brush.shape, PaintBrush::Shape::Contour);
  for (const Eigen::Vector3d& at : {Eigen::Vector3d(20, 20, 0), Eigen::Vector3d(26, 24, 0)}) EXPECT_EQ(label_at(at), 1);
  EXPECT_EQ(label_at({30, 22, 0}), 0);
  EXPECT_EQ(label_at({23, 22, 1}), 0) << "in its slice alone";
  press(Act::Brush3d);
  drag(axial(), around);
  EXPECT_EQ(label_at({23, 22, 15}), 1) << "through the volume";
  press(Act::ToolEraser);
  drag(axial(), {pixel(17, 17), pixel(23, 17), pixel(23, 27), pixel(17, 27)});
  EXPECT_EQ(label_at({20, 22, 15}), 0) << "scissors";
  EXPECT_EQ(label_at({26, 22, 15}), 1);
  const std::size_t strokes = scene().points.size();
  drag(axial(), pixel(20, 20), pixel(20, 20));
  EXPECT_EQ(scene().points.size(), strokes) << "a click encloses nothing";
}

TEST_F(PaintTest, TheSmartBrushStopsAtEdges) {
  press(Act::ToolBrush);
  press(Act::SmartBrush);
  bench().view.brush_mm = 7;
  drag(axial(), pixel(13, 0), pixel(13, 0));  // the sphere of the image ends before 18 mm, the mesh at 12 mm
  ASSERT_EQ(scene().points.size(), 1u);
  EXPECT_EQ(bench().session().undo_title(), std::string("smart paint"));
  EXPECT_EQ(label_at({14, 0, 0}), 1);
  EXPECT_EQ(label_at({19, 0, 0}), 0);
}

TEST_F(PaintTest, AFrozenPartIsOutlinedAndKeepsItsVoxels) {
  press(Act::ToolFreeze);
  EXPECT_TRUE(window_->actions()[Act::ToolFreeze]->isChecked());
  press(Act::Brush3d);
  bench().view.brush_mm = 6;
  const int none = count_pixels(theme::kFrozen);
  drag(axial(), pixel(10, 0), pixel(14, 0));
  mouse(axial(), QEvent::MouseMove, pixel(-25, -25), Qt::NoButton, Qt::NoButton);
  EXPECT_GT(count_pixels(theme::kFrozen), none + 60);
  EXPECT_EQ(bench().session().undo_title(), std::string("freeze"));
  EXPECT_EQ(label_at({11, 0, 0}), 1);
  EXPECT_EQ(label_at({14, 0, 0}), 0);
  bench().apply(EditVoxels{scene().meshes[0].id, VoxelEdit::Margin, 3});
  EXPECT_EQ(label_at({0, 14, 0}), 1);
  const auto* list = window_->findChild<PointPanel*>()->findChild<QTreeWidget*>();
  ASSERT_EQ(list->topLevelItemCount(), 2);
  EXPECT_EQ(list->topLevelItem(0)->text(1), "Freeze");
  EXPECT_EQ(list->topLevelItem(1)->text(1), "Move surface");
}

TEST_F(PaintTest, TheMenuChangesVoxels) {
  auto* menu = window_->findChild<QMenu*>("voxel_menu");
  ASSERT_TRUE(menu);
  const auto entry = [&](const char* name) { return menu->findChild<QAction*>(name); };
  EXPECT_FALSE(menu->findChild<QMenu*>("add")->menuAction()->isEnabled()) << "there is no other segmentation";
  EXPECT_EQ(label_at({14, 0, 0}), 0);
  entry("margin")->trigger();
  auto* dialog = window_->findChild<QInputDialog*>("voxel_size");
  ASSERT_TRUE(dialog);
  dialog->setDoubleValue(3);
  dialog->accept();
  EXPECT_EQ(bench().session().undo_title(), std::string("move surface"));
  EXPECT_EQ(label_at({14, 0, 0}), 1);
  press(Act::Undo);
  EXPECT_EQ(label_at({14, 0, 0}), 0);
  entry("keep_largest")->trigger();
  EXPECT_TRUE(window_->messages().text().contains("no voxel")) << window_->messages().text().toStdString();
  const ItemId first = scene().meshes[0].id;
  bench().apply(AddMesh{"other", {bench().view.crosshair_mm + Eigen::Vector3d(14, 0, 0), 6}, std::nullopt});
  bench().set_active_mesh(first);
  auto* others = menu->findChild<QMenu*>("subtract");
  EXPECT_TRUE(others->menuAction()->isEnabled());
  emit others->aboutToShow();
  ASSERT_EQ(others->actions().size(), 1);
  EXPECT_EQ(others->actions()[0]->text(), "other");
  others->actions()[0]->trigger();
  EXPECT_EQ(bench().session().undo_title(), std::string("subtract segmentation"));
  EXPECT_EQ(label_at({10, 0, 0}), 2);
}

TEST_F(PaintTest, NeedsASegmentation) {
  bench().apply(DeleteMesh{scene().meshes[0].id});
  EXPECT_FALSE(window_->actions()[Act::ToolBrush]->isEnabled());
  bench().view.tool = Tool::Brush;
  drag(axial(), pixel(4, 4), pixel(9, 4));
  EXPECT_TRUE(scene().points.empty());
}

TEST_F(PaintTest, OfALockedSegmentationIsRefused) {
  bench().apply(EditMesh{scene().meshes[0].id, {}, {}, {}, {}, true});
  press(Act::ToolBrush);
  drag(axial(), pixel(4, 4), pixel(9, 4));
  EXPECT_TRUE(scene().points.empty());
}

TEST(PaintOutline, SurroundsTexelsAndDistinguishesErasedOnes) {
  SliceGrid slice;
  slice.width = 20, slice.height = 10;
  const std::vector<PaintStroke> strokes{
      {true, {{5, 5, 0}}, 0.1}, {true, {{6, 5, 0}}, 0.1}, {false, {{12, 5, 0}}, 0.1}};
  const PaintOutline outline = outline_of(strokes, {}, slice, 1);
  EXPECT_EQ(outline.painted.size(), 12u) << "six sides of two texels";
  EXPECT_EQ(outline.erased.size(), 8u);
  for (const Eigen::Vector3f& end : outline.painted) {
    EXPECT_TRUE(end.x() == 4.5f || end.x() == 5.5f || end.x() == 6.5f) << end.transpose();
    EXPECT_TRUE(end.y() == 4.5f || end.y() == 5.5f) << end.transpose();
  }
  EXPECT_TRUE(outline_of(strokes, {}, {{0, 0, 50}, {1, 0, 0}, {0, 1, 0}, 20, 10}, 1).painted.empty());
}

}  // namespace
}  // namespace simplexseg
