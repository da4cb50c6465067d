// SPDX-License-Identifier: Apache-2.0
// Layout of the panels at usual window sizes: nothing is covered or cut off.
#include <QDoubleSpinBox>
#include <QLabel>
#include <QMenu>
#include <QMenuBar>
#include <QScreen>
#include <QScrollArea>
#include <QScrollBar>
#include <QStatusBar>
#include <QTabBar>
#include <QTabWidget>
#include <QToolButton>

#include "gui/look/widgets.h"
#include "gui/panels/force_panel.h"
#include "gui/panels/parameter_row.h"
#include "gui/panels/simulation_panel.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class LayoutTest : public PausedPhantomTest {
 protected:
  void resize(int width, int height) {
    window_->resize(width, height);
    ASSERT_TRUE(wait_until([&] { return window_->size() == QSize(width, height); })) << window_->height();
    for (int n = 0; n < 5; ++n) QApplication::processEvents();
  }
};

TEST_F(LayoutTest, EverythingFitsAWindowOf800x600) {
  EXPECT_LE(window_->minimumSizeHint().height(), 600);
  EXPECT_LE(window_->minimumSizeHint().width(), 800);
  resize(800, 600);
  for (const bool researcher : {false, true}) {
    window_->panels().set_researcher(researcher);
    QApplication::processEvents();
    EXPECT_EQ(window_->size(), QSize(800, 600));
    EXPECT_TRUE(
        window_->rect().contains(QRect(window_->panels().mapTo(window_.get(), QPoint()), window_->panels().size())));
  }
}

TEST_F(LayoutTest, AWindowIsNotLargerThanItsScreen) {
  EXPECT_EQ(size_within({1280, 800}, QRect(0, 0, 1920, 1080)), QSize(1280, 800));
  const QSize small = size_within({1280, 800}, QRect(0, 0, 960, 540));  // a screen of 1920x1080 at 200 %
  EXPECT_LE(small.width(), 960);
  EXPECT_LE(small.height(), 540);
  EXPECT_GE(small.height(), 480);
  const QRect area = window_->screen()->availableGeometry();
  QWidget window;
  window.resize(area.size() + QSize(300, 200));
  fit_on_screen(window);
  EXPECT_LT(window.width(), area.width());
  EXPECT_LT(window.height(), area.height());
  window.resize(200, 100);
  fit_on_screen(window);
  EXPECT_EQ(window.size(), QSize(200, 100));
}

TEST_F(LayoutTest, TextsOfTheStatusLineAreNotCut) {
  bench().view.crosshair_mm = bench().session().volume().geometry().centre_mm();
  for (const QSize& size : {QSize(800, 600), QSize(1600, 1000)}) {
    resize(size.width(), size.height());
    for (const QLabel* label : window_->statusBar()->findChildren<QLabel*>()) {
      if (!label->isVisible() || !label->text().startsWith("LPS")) continue;
      EXPECT_GE(label->width(), label->sizeHint().width()) << label->text().toStdString();
      EXPECT_EQ(label->text().contains("voxel"), label->toolTip().isEmpty()) << "the full text is in the tooltip";
    }
  }
}

TEST_F(LayoutTest, PlanAndConvergenceLieBelowTheirTabs) {
  for (const QSize& size : {QSize(1280, 700), QSize(1600, 1100)}) {
    resize(size.width(), size.height());
    for (const char* title : {"Plan", "Convergence"}) {
      window_->panels().show_panel(title);
      QApplication::processEvents();
      const QWidget* panel = window_->panels().findChild<QWidget*>(title);
      ASSERT_TRUE(panel && panel->isVisible()) << title;
      auto* tabs = qobject_cast<QTabWidget*>(panel->parentWidget()->parentWidget());
      ASSERT_NE(tabs, nullptr);
      EXPECT_GE(panel->mapTo(tabs, QPoint()).y(), tabs->tabBar()->geometry().bottom());
      EXPECT_LE(panel->mapTo(tabs, QPoint(0, panel->height())).y(), tabs->height());
      EXPECT_GE(panel->height(), panel->minimumSizeHint().height());
    }
  }
}

TEST_F(LayoutTest, PlanAndConvergenceAreInTheResearchersLayoutOnly) {
  const QWidget* plan = window_->panels().findChild<QWidget*>("Plan");
  EXPECT_FALSE(plan->isVisible());
  window_->actions()[Act::Researcher]->trigger();
  window_->panels().show_panel("Plan");
  EXPECT_TRUE(plan->isVisible());
  window_->actions()[Act::Researcher]->trigger();
  EXPECT_FALSE(plan->isVisible());
  window_->panels().show_panel("Plan");  // switches to the layout with this panel
  EXPECT_TRUE(window_->actions()[Act::Researcher]->isChecked());
}

TEST_F(LayoutTest, TheCliniciansLayoutIsTheDefaultAndNamesNoForces) {
  const auto tabs_shown = [&] {
    QStringList titles;
    for (const QTabBar* bar : window_->panels().findChildren<QTabBar*>())
      for (int n = 0; n < bar->count() && bar->isVisible(); ++n) titles << bar->tabText(n);
    return titles;
  };
  const auto menus = [&] {
    QStringList entries;
    for (const QMenu* menu : window_->menuBar()->findChildren<QMenu*>())
      for (const QAction* entry : menu->actions())
        if (entry->isVisible()) entries << entry->text();
    return entries.join('\n');
  };
  EXPECT_EQ(tabs_shown(), (QStringList{"Points", "Intensity", "Check"}));
  for (const char* word : {"fine", "profiles", "One step", "Compare"})
    EXPECT_FALSE(menus().contains(word)) << menus().toStdString();
  window_->actions()[Act::Researcher]->trigger();
  QApplication::processEvents();
  EXPECT_EQ(tabs_shown().mid(0, 5), (QStringList{"Forces", "Simulation", "Points", "Intensity", "Check"}));
  EXPECT_EQ(tabs_shown().size(), 7);
  for (const char* word : {"fine", "profiles", "One step", "Compare"}) EXPECT_TRUE(menus().contains(word)) << word;
  window_->actions()[Act::Researcher]->trigger();
  QApplication::processEvents();
  EXPECT_EQ(tabs_shown(), (QStringList{"Points", "Intensity", "Check"}));
}

TEST_F(LayoutTest, ViewsCanBeArrangedAroundALargeOne) {
  resize(1280, 700);
  auto* menu = window_->findChild<QMenu*>("view_layout_menu");
  ASSERT_TRUE(menu);
  const auto choose = [&](const QString& title) { choose_entry({menu}, title); };
  const ViewGrid& views = window_->views();
  const auto area = [&](int n) { return views.all()[static_cast<std::size_t>(n)]->size(); };
  const QSize quarter = area(0);
  choose("Coronal large, three beside it");
  EXPECT_GT(area(2).height(), 1.8 * quarter.height());
  for (const int n : {0, 1, 3}) {
    EXPECT_TRUE(views.all()[static_cast<std::size_t>(n)]->isVisible());
    EXPECT_LT(area(n).height(), 0.8 * quarter.height());
    EXPECT_GT(area(n).width(), 100);
  }
  choose("3D alone");
  EXPECT_TRUE(views.all()[3]->isVisible());
  EXPECT_FALSE(views.all()[0]->isVisible());
  window_->views().show_alone(-1);
  for (int n = 0; n < 5; ++n) QApplication::processEvents();
  EXPECT_GT(area(2).height(), 1.8 * quarter.height()) << "back to the layout before";
  choose("Four views");
  EXPECT_EQ(area(0), quarter);
}

TEST_F(LayoutTest, TheScrollBarOfTheForcesCoversNothing) {
  resize(1280, 700);
  window_->panels().show_panel("Forces");
  ForcePanel& forces = window_->panels().forces();
  for (QToolButton* unfold : forces.findChildren<QToolButton*>())
    if (unfold->accessibleName().startsWith("Parameters of")) unfold->click();
  auto* scroll = forces.findChild<QScrollArea*>();
  ASSERT_TRUE(wait_until([&] { return scroll->verticalScrollBar()->isVisible(); }));
  const int end = scroll->viewport()->width();
  for (const QDoubleSpinBox* number : forces.findChildren<QDoubleSpinBox*>()) {
    const QWidget* content = scroll->widget();
    EXPECT_LE(number->mapTo(content, QPoint(number->width(), 0)).x(), end) << number->toolTip().toStdString();
  }
}

TEST_F(LayoutTest, TheSimulationShowsItsParameters) {
  resize(1600, 1000);
  window_->panels().show_panel("Simulation");
  SimulationPanel& panel = window_->panels().simulation();
  ASSERT_TRUE(wait_until([&] { return panel.isVisible(); }));
  int shown = 0;
  for (std::size_t p = 0; p < simulation_table().size(); ++p)
    shown += !panel.row(static_cast<int>(p))->visibleRegion().isEmpty();
  EXPECT_GE(shown, 6);
  window_->panels().set_researcher(true);
  for (int n = 0; n < 5; ++n) QApplication::processEvents();
  shown = 0;
  for (std::size_t p = 0; p < simulation_table().size(); ++p)
    shown += !panel.row(static_cast<int>(p))->visibleRegion().isEmpty();
  EXPECT_GE(shown, 6);
}

}  // namespace
}  // namespace simplexseg
