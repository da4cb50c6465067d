// SPDX-License-Identifier: Apache-2.0
// Rulers, angles, ellipses, and the axes of objects: tests send events and check the scene, the values and the picture.
#include <QAction>
#include <QFile>
#include <QHeaderView>
#include <QKeyEvent>
#include <QTableWidget>
#include <QTest>
#include <QToolBar>
#include <QToolButton>
#include <QTreeWidget>

#include "gui/look/theme.h"
#include "gui/panels/check_panel.h"
#include "gui/panels/measurement_list.h"
#include "gui/views/measure_tool.h"
#include "gui/views/measurement_layer.h"
#include "gui/window/file_actions.h"
#include "gui/window/message_bar.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class MeasureTest : public PausedPhantomTest {
 protected:
  QPointF pixel(double right_mm, double up_mm) { return pixel_in(axial(), right_mm, up_mm); }
  QPointF pixel_in(SliceView& view, double right_mm, double up_mm) {
    const SliceAxes axes = view.axes();
    return view.pixel_of(bench().view.crosshair_mm + right_mm * axes.right + up_mm * axes.up);
  }
  void click(const QPointF& at) {
    mouse(axial(), QEvent::MouseMove, at, Qt::NoButton, Qt::NoButton);
    mouse(axial(), QEvent::MouseButtonPress, at, Qt::LeftButton, Qt::LeftButton);
    mouse(axial(), QEvent::MouseButtonRelease, at, Qt::LeftButton, Qt::NoButton);
  }
  void draw_ruler() {
    press(Act::ToolRuler);
    drag(axial(), pixel(-10, 4), pixel(10, 4));
  }
  const Measurement& only() {
    EXPECT_EQ(scene().measurements.size(), 1u);
    return scene().measurements.at(0);
  }
};

TEST_F(MeasureTest, ARulerIsADragAndItsEndsCanBeDragged) {
  draw_ruler();
  EXPECT_NEAR(ruler_length_mm(only()), 20, 0.01);
  EXPECT_EQ(only().name, "ruler 1");
  EXPECT_EQ(bench().view.selected_measurement(), only().id);
  const std::vector<Eigen::Vector3d> before = only().points_mm;
  drag(axial(), pixel(10, 4), pixel(20, 4));
  EXPECT_NEAR(ruler_length_mm(only()), 30, 0.01);
  EXPECT_EQ(bench().session().history().undo_names().size(), 2u) << "a drag is one action";
  press(Act::Undo);
  EXPECT_EQ(only().points_mm, before);
  press(Act::Undo);
  EXPECT_TRUE(scene().measurements.empty());
  press(Act::Redo), press(Act::Redo);
  EXPECT_NEAR(ruler_length_mm(only()), 30, 0.01);
}

TEST_F(MeasureTest, ItsLineMovesTheWholeAlsoWithTheCrosshairTool) {
  draw_ruler();
  press(Act::ToolCrosshair);
  const Eigen::Vector3d crosshair = bench().view.crosshair_mm;
  const std::vector<Eigen::Vector3d> before = only().points_mm;
  drag(axial(), pixel(3, 4), pixel(3, -9));
  EXPECT_EQ(bench().view.crosshair_mm, crosshair);
  for (const std::size_t end : {0u, 1u})
    EXPECT_NEAR((only().points_mm[end] - before[end]).dot(axial().axes().up), -13, 0.01);
  EXPECT_NEAR(ruler_length_mm(only()), 20, 1e-9);
  click(pixel(-10, -9));  // a click selects, and does not move
  EXPECT_NEAR(ruler_length_mm(only()), 20, 1e-9);
  drag(axial(), pixel(20, 20), pixel(22, 20));
  EXPECT_NE(bench().view.crosshair_mm, crosshair) << "elsewhere the tool moves the crosshair";
}

TEST_F(MeasureTest, AnAngleIsThreeClicksOrADragAndAClick) {
  press(Act::ToolAngle);
  click(pixel(10, 0));
  click(pixel(0, 0));
  EXPECT_TRUE(scene().measurements.empty());
  click(pixel(0, 8));
  EXPECT_NEAR(angle_degrees(only()), 90, 0.1);
  drag(axial(), pixel(-10, -14), pixel(-20, -14));
  click(pixel(-13, -7));
  ASSERT_EQ(scene().measurements.size(), 2u);
  EXPECT_NEAR(angle_degrees(scene().measurements[1]), 45, 0.2);
  drag(axial(), pixel(0, 8), pixel(-8, 0));
  EXPECT_NEAR(angle_degrees(scene().measurements[0]), 180, 0.2);
}

TEST_F(MeasureTest, AnEllipseMeasuresTheVoxelsInIt) {
  press(Act::ToolEllipse);
  drag(axial(), pixel(-12, 8), pixel(12, -8));
  EXPECT_NEAR(ellipse_area_mm2(only()), std::numbers::pi * 12 * 8, 0.5);
  const auto inside = ellipse_intensities(only(), bench().session().volume());
  ASSERT_TRUE(inside);
  EXPECT_NEAR(static_cast<double>(inside->voxels), std::numbers::pi * 12 * 8, 12);
  const Eigen::Vector3d at = bench().view.crosshair_mm;
  EXPECT_NEAR(inside->mean, bench().session().volume().sample(at), 3 * inside->deviation + 1e-9);
  // An end of an axis turns and scales the ellipse about its centre.
  const Eigen::Vector3d centre = only().points_mm[0];
  drag(axial(), pixel(12, 0), pixel(0, 15));
  EXPECT_LT((only().points_mm[0] - centre).norm(), 1e-9);
  EXPECT_NEAR(ellipse_area_mm2(only()), std::numbers::pi * 15 * 8, 0.5);
  EXPECT_NEAR((only().points_mm[2] - centre).normalized().dot(axial().axes().up), 0, 1e-6);
  drag(axial(), pixel(0, 0), pixel(5, 5));  // its centre moves the whole
  EXPECT_NEAR((only().points_mm[0] - centre).norm(), std::hypot(5, 5), 0.01);
  EXPECT_NEAR(ellipse_area_mm2(only()), std::numbers::pi * 15 * 8, 0.5);
}

TEST_F(MeasureTest, EscapeCancelsWhatIsBeingDrawn) {
  press(Act::ToolAngle);
  click(pixel(10, 0));
  click(pixel(0, 0));
  mouse(axial(), QEvent::MouseMove, pixel(-3, 9), Qt::NoButton, Qt::NoButton);
  const int drawn = count_pixels(theme::kMeasurement);
  EXPECT_GT(drawn, 20);
  QTest::keyClick(&axial(), Qt::Key_Escape);
  EXPECT_EQ(count_pixels(theme::kMeasurement), 0);
  click(pixel(0, 8));
  EXPECT_TRUE(scene().measurements.empty()) << "it was the first click of the next angle";
  QTest::keyClick(&axial(), Qt::Key_Escape);
  press(Act::ToolRuler);
  click(pixel(0, 8));
  EXPECT_TRUE(scene().measurements.empty()) << "a click is no ruler";
}

TEST_F(MeasureTest, AnotherToolOrSliceDiscardsWhatIsBeingDrawn) {
  for (const bool tool : {true, false}) {
    press(Act::ToolAngle);
    click(pixel(10, 0));
    click(pixel(0, 0));
    tool ? press(Act::ToolRuler) : wheel(axial(), pixel(5, 5), 1, Qt::NoModifier);
    press(Act::ToolAngle);
    if (tool) continue;
    click(pixel(0, 8));
    EXPECT_TRUE(scene().measurements.empty());
  }
}

TEST_F(MeasureTest, DeleteRemovesTheOneUnderTheMouseElseTheSelectedOne) {
  draw_ruler();
  drag(axial(), pixel(-10, -12), pixel(10, -12));
  ASSERT_EQ(scene().measurements.size(), 2u);
  const ItemId first = scene().measurements[0].id;
  mouse(axial(), QEvent::MouseMove, pixel(2, 4), Qt::NoButton, Qt::NoButton);
  EXPECT_EQ(bench().view.hovered_measurement, first);
  press(Act::DeletePoint);
  EXPECT_NE(only().id, first);
  mouse(axial(), QEvent::MouseMove, pixel(25, 25), Qt::NoButton, Qt::NoButton);
  EXPECT_EQ(bench().view.hovered_measurement, 0u);
  press(Act::DeletePoint);
  EXPECT_TRUE(scene().measurements.empty());
  press(Act::Undo);
  EXPECT_EQ(scene().measurements.size(), 1u);
  // A point that was selected later comes first.
  bench().apply(AddPoint{scene().meshes[0].id, bench().view.crosshair_mm + Eigen::Vector3d(5, 5, 0)});
  press(Act::DeletePoint);
  EXPECT_TRUE(scene().points.empty());
  EXPECT_EQ(scene().measurements.size(), 1u);
}

TEST_F(MeasureTest, IsDrawnInItsSliceOnly) {
  EXPECT_EQ(count_pixels(theme::kSelected), 0);
  draw_ruler();
  mouse(axial(), QEvent::MouseMove, pixel(25, 25), Qt::NoButton, Qt::NoButton);
  EXPECT_GT(count_pixels(theme::kSelected), 60) << "selected";
  bench().view.last_measurement = 0;
  bench().view_edited();
  EXPECT_GT(count_pixels(theme::kMeasurement), 60);
  bench().set_crosshair(bench().view.crosshair_mm + Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(count_pixels(theme::kMeasurement), 0);
  EXPECT_FALSE(measurement_in_slice(bench(), axial(), pixel(10, 4)));
}

TEST_F(MeasureTest, ASimulationThatIsPausedStaysPausedAndAPointIsNotCovered) {
  draw_ruler();
  EXPECT_FALSE(bench().running());
  bench().apply(AddPoint{scene().meshes[0].id, only().points_mm[1]});
  press(Act::ToolCrosshair);
  const double length = ruler_length_mm(only());
  drag(axial(), pixel(10, 4), pixel(14, 4));
  EXPECT_EQ(ruler_length_mm(only()), length) << "the point was dragged";
}

TEST_F(MeasureTest, TheListShowsTheValuesAndGoesToTheSlice) {
  draw_ruler();
  window_->panels().show_panel("Check");
  auto* list = window_->findChild<MeasurementList*>();
  ASSERT_EQ(list->topLevelItemCount(), 1);
  EXPECT_TRUE(list->isVisible());
  EXPECT_EQ(list->topLevelItem(0)->text(0), "ruler 1");
  EXPECT_EQ(list->topLevelItem(0)->text(1), "20.0 mm");
  const double z = bench().view.crosshair_mm.z();
  bench().set_crosshair(bench().view.crosshair_mm + Eigen::Vector3d(0, 0, 9));
  emit list->itemClicked(list->topLevelItem(0), 0);
  list->setCurrentItem(list->topLevelItem(0));
  emit list->itemClicked(list->topLevelItem(0), 0);
  EXPECT_NEAR(bench().view.crosshair_mm.z(), z, 1e-9);
  list->topLevelItem(0)->setText(0, "width");
  EXPECT_TRUE(wait_until([&] { return only().name == "width"; }));
  press(Act::DeletePoint);
  EXPECT_FALSE(list->isVisible());
}

TEST_F(MeasureTest, TheButtonOfTheToolbarShowsTheToolChosenLast) {
  auto* button = window_->findChild<QToolBar*>("tools")->findChild<QToolButton*>("measure");
  ASSERT_NE(button, nullptr);
  EXPECT_EQ(button->defaultAction(), window_->actions()[Act::ToolRuler]);
  press(Act::ToolEllipse);
  EXPECT_EQ(button->defaultAction(), window_->actions()[Act::ToolEllipse]);
  EXPECT_TRUE(button->isChecked());
  press(Act::ToolCrosshair);
  EXPECT_FALSE(button->isChecked());
  EXPECT_EQ(button->defaultAction(), window_->actions()[Act::ToolEllipse]);
}

TEST_F(MeasureTest, LongAndShortAxisAreShownInTheirSlice) {
  press(Act::ShowAxes);
  ASSERT_TRUE(wait_until([&] { return bench().view.object_axes && !bench().view.object_axes->empty(); }));
  const ObjectAxes axes = bench().view.object_axes->begin()->second;
  EXPECT_NEAR(axes.long_mm(), 24, 0.6);
  EXPECT_NEAR(axes.short_mm(), 24, 0.6);
  window_->panels().show_panel("Check");
  auto* table = window_->findChild<CheckPanel*>()->findChild<QTableWidget*>();
  int row = 0;
  while (table->verticalHeaderItem(row)->text() != "Long axis") ++row;
  ASSERT_TRUE(wait_until([&] { return table->item(row, 0) && table->item(row, 0)->text().endsWith("mm"); }));
  bench().set_crosshair(bench().view.crosshair_mm + Eigen::Vector3d(0, 0, 8));
  emit table->cellClicked(row, 0);
  EXPECT_NEAR(bench().view.crosshair_mm.z(), axes.long_ends_mm[0].z(), 1e-6);
  const std::string csv = window_->findChild<CheckPanel*>()->csv();
  EXPECT_NE(csv.find(",long_axis_mm,short_axis_mm,slice\n"), std::string::npos);
  const Colour colour = scene().meshes[0].colour;
  const QColor line(colour.red, colour.green, colour.blue);
  const int shown = count_pixels(line);
  press(Act::ShowAxes);
  EXPECT_GT(shown, count_pixels(line) + 60);
}

TEST_F(MeasureTest, TheTableIsSaved) {
  draw_ruler();
  const QString path = folder_.filePath("measurements.csv");
  window_->files().save_measurements_to(path);
  QFile file(path);
  ASSERT_TRUE(wait_until([&] { return file.exists(); }));
  ASSERT_TRUE(file.open(QIODevice::ReadOnly));
  const QByteArray text = file.readAll();
  EXPECT_TRUE(text.contains("\nruler 1,ruler,20")) << text.toStdString();
  EXPECT_TRUE(text.contains("\nobject,segmentation,")) << text.toStdString();
}

TEST_F(MeasureTest, AReportOfTheCaseIsSaved) {
  draw_ruler();
  const QString path = folder_.filePath("case.pdf");
  window_->messages().clear();
  window_->files().save_measurements_to(path);
  ASSERT_TRUE(wait_until([&] { return window_->messages().text().startsWith("Saved"); }));
  QFile file(path);
  ASSERT_TRUE(file.open(QIODevice::ReadOnly));
  EXPECT_TRUE(file.read(5) == "%PDF-");
  // The volume is not DICOM, so a structured report is refused before anything is measured.
  window_->messages().clear();
  window_->files().save_measurements_to(folder_.filePath("case.sr.dcm"));
  EXPECT_FALSE(window_->messages().text().isEmpty());
  EXPECT_FALSE(QFile::exists(folder_.filePath("case.sr.dcm")));
  EXPECT_FALSE(QFile::exists(folder_.filePath("case.seg.dcm")));
}

}  // namespace
}  // namespace simplexseg
