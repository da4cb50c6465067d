// SPDX-License-Identifier: Apache-2.0
// Range of intensities and local marks: tests send events and check the scene, the fields and the picture.
#include <QAction>
#include <QDoubleSpinBox>
#include <QPushButton>
#include <QTest>
#include <QToolButton>

#include "gui/panels/intensity_panel.h"
#include "gui/panels/intensity_plot.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class IntensityTest : public PausedPhantomTest {
 protected:
  void SetUp() override {
    PausedPhantomTest::SetUp();
    window_->panels().show_panel("Intensity");
    QCoreApplication::processEvents();
  }
  IntensityPanel& panel() { return *window_->findChild<IntensityPanel*>(); }
  IntensityPlot& plot() { return *panel().findChild<IntensityPlot*>(); }
  IntensityRange range() { return scene().meshes.at(0).intensity_range; }
  void drag_plot(double from, double to, bool release = true) {
    const double y = plot().height() / 2.0;
    mouse(plot(), QEvent::MouseButtonPress, {from, y}, Qt::LeftButton, Qt::LeftButton);
    mouse(plot(), QEvent::MouseMove, {0.5 * (from + to), y}, Qt::NoButton, Qt::LeftButton);
    mouse(plot(), QEvent::MouseMove, {to, y}, Qt::NoButton, Qt::LeftButton);
    if (release) mouse(plot(), QEvent::MouseButtonRelease, {to, y}, Qt::LeftButton, Qt::NoButton);
  }
  QPointF pixel_from_seed(double right_mm, double up_mm) {
    const SliceAxes axes = axial().axes();
    return axial().pixel_of(scene().meshes.at(0).seed.centre_mm + right_mm * axes.right + up_mm * axes.up);
  }
};

TEST_F(IntensityTest, AHandleOfTheHistogramLimitsTheSegmentationAsOneAction) {
  const IntensityRange all = plot().histogram().range;
  const double middle = 0.5 * (all.low + all.high);
  ASSERT_FALSE(range().is_limited());
  drag_plot(plot().x_of(all.low), plot().x_of(middle), false);
  EXPECT_FALSE(range().is_limited()) << "while the handle is dragged only a preview is shown";
  ASSERT_TRUE(bench().view.range_preview);
  EXPECT_NEAR(bench().view.range_preview->low, middle, 0.02 * (all.high - all.low));
  mouse(plot(), QEvent::MouseButtonRelease, {plot().x_of(middle), plot().height() / 2.0}, Qt::LeftButton, Qt::NoButton);
  EXPECT_FALSE(bench().view.range_preview);
  EXPECT_NEAR(range().low, middle, 0.02 * (all.high - all.low));
  EXPECT_EQ(range().high, IntensityRange{}.high);
  press(Act::Undo);
  EXPECT_FALSE(range().is_limited());
  press(Act::Redo);
  drag_plot(plot().x_of(range().low), -20);
  EXPECT_FALSE(range().is_limited()) << "at the end of the plot there is no limit";
}

TEST_F(IntensityTest, ThePreviewTintsTheIntensitiesInTheRange) {
  const auto tinted = [&] {
    axial().repaint();
    const QImage picture = axial().grabFramebuffer();
    int count = 0;
    for (int y = 0; y < picture.height(); y += 2)
      for (int x = 0; x < picture.width(); x += 2) count += QColor(picture.pixel(x, y)).saturation() > 60;
    return count;
  };
  const int before = tinted();
  const IntensityRange all = plot().histogram().range;
  bench().view.range_preview = IntensityRange{0.5 * (all.low + all.high), all.high + 1};
  bench().view_edited();
  EXPECT_GT(tinted(), before + 200);
  bench().view.range_preview.reset();
  bench().view_edited();
  EXPECT_NEAR(tinted(), before, 20);
}

TEST_F(IntensityTest, ADragOverTissueSetsTheRange) {
  const double r = 20;  // beyond the sphere, which has a single intensity
  press(Act::ToolRange);
  ASSERT_EQ(bench().view.tool, Tool::Range);
  drag(axial(), pixel_from_seed(-r, -r), pixel_from_seed(r, r));
  ASSERT_TRUE(range().is_limited());
  const double centre = bench().session().volume().sample(scene().meshes.at(0).seed.centre_mm);
  EXPECT_LE(range().low, centre);
  EXPECT_GE(range().high, centre);
  EXPECT_EQ(bench().view.tool, Tool::Crosshair);
  auto* remove = panel().findChildren<QPushButton*>().at(0);
  ASSERT_TRUE(remove->isEnabled());
  remove->click();
  EXPECT_FALSE(range().is_limited());
  EXPECT_FALSE(remove->isEnabled());
}

TEST_F(IntensityTest, TheFieldsTakeNumbersAndRefuseAnEmptyRange) {
  const QList<QDoubleSpinBox*> boxes = panel().findChildren<QDoubleSpinBox*>();
  ASSERT_EQ(boxes.size(), 2);
  EXPECT_EQ(boxes[0]->text(), "none");
  boxes[0]->setValue(80);
  EXPECT_EQ(range().low, 80);
  boxes[1]->setValue(40);
  EXPECT_EQ(range().high, IntensityRange{}.high) << "refused";
  EXPECT_EQ(boxes[1]->text(), "none") << "the previous limit is shown again";
  boxes[1]->setValue(140);
  EXPECT_EQ(range(), (IntensityRange{80, 140}));
}

TEST_F(IntensityTest, LocalMarksAreAStateOfTheToolsAndAPropertyOfTheMark) {
  press(Act::LocalMarks);
  ASSERT_TRUE(bench().view.local_marks);
  press(Act::ToolOutside);
  const double r = scene().meshes.at(0).seed.radius_mm;
  drag(axial(), pixel_from_seed(2 * r, 0), pixel_from_seed(2 * r, 5));
  ASSERT_EQ(scene().points.size(), 1u);
  EXPECT_TRUE(scene().points[0].local);
  press(Act::LocalMarks);
  drag(axial(), pixel_from_seed(-2 * r, 0), pixel_from_seed(-2 * r, 5));
  ASSERT_EQ(scene().points.size(), 2u);
  EXPECT_FALSE(scene().points[1].local);
  EXPECT_TRUE(scene().points[0].local);
}

}  // namespace
}  // namespace simplexseg
