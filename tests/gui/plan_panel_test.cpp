// SPDX-License-Identifier: Apache-2.0
// Plan panel: its list follows the actions of the user.
#include "gui/panels/plan_panel.h"
#include "forces/force_list.h"

#include <QLabel>
#include <QSlider>
#include <QTreeWidget>

#include "gui/panels/force_panel.h"
#include "gui/panels/parameter_row.h"
#include "gui/window/message_bar.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class PlanPanelTest : public PausedPhantomTest {
 protected:
  void SetUp() override {
    PausedPhantomTest::SetUp();
    if (IsSkipped()) return;
    window_->panels().show_panel("Plan");
    wait_until([&] { return window_->panels().plan().on_screen(); });
  }
  QTreeWidget& list() { return *window_->panels().plan().findChild<QTreeWidget*>(); }
  static void collect(const QTreeWidgetItem* row, QStringList& names) {
    for (int n = 0; n < row->childCount(); ++n) {
      if (row->child(n)->childCount() == 0) names << row->child(n)->text(0);
      collect(row->child(n), names);
    }
  }
  /// Names of the rows in a group: 0 in memory, 1 computed, 2 not needed.
  QStringList rows(int group) {
    QStringList names;
    collect(list().topLevelItem(group), names);
    return names;
  }
  /// Memory in use, without its share of the available memory, which varies on a device.
  QString totals() { return window_->panels().plan().findChild<QLabel*>()->text().section(" in use", 0, 0); }
};

TEST_F(PlanPanelTest, AForceWithWeightZeroIsListedAsNotNeeded) {
  bench().apply(SetForceParameter{0, ForceId::Evidence, EvidenceForce::source, 1});  // else a field is solved first
  ASSERT_EQ(list().topLevelItemCount(), 3);
  EXPECT_FALSE(rows(0).contains("evidence targets"));
  EXPECT_TRUE(rows(2).contains("evidence targets"));
  const QString before = totals();
  QSlider* slider = window_->panels().forces().row(ForceId::Evidence, 0)->slider();
  slider->setValue(700);
  EXPECT_TRUE(rows(0).contains("evidence targets"));
  EXPECT_TRUE(rows(1).contains("evidence search"));
  EXPECT_FALSE(rows(2).contains("evidence targets"));
  EXPECT_NE(totals(), before);
  slider->setValue(0);
  EXPECT_FALSE(rows(0).contains("evidence targets"));
  EXPECT_FALSE(rows(1).contains("evidence search"));
  EXPECT_TRUE(rows(2).contains("evidence targets"));
  EXPECT_EQ(totals(), before);
}

TEST_F(PlanPanelTest, SkippedItemsAreGroupedByReason) {
  const QTreeWidgetItem* skipped = list().topLevelItem(2);
  QStringList reasons;
  for (int n = 0; n < skipped->childCount(); ++n) {
    reasons << skipped->child(n)->text(0);
    EXPECT_GT(skipped->child(n)->childCount(), 0);
  }
  EXPECT_TRUE(reasons.contains("there is no attraction point")) << reasons.join("\n").toStdString();
  EXPECT_TRUE(reasons.contains("the weight of gradient is 0 for every mesh")) << reasons.join("\n").toStdString();
}

TEST_F(PlanPanelTest, EveryItemOfThePlanIsARow) {
  const StepPlan plan = bench().session().plan();
  EXPECT_EQ(rows(0).size() + rows(1).size() + rows(2).size(), static_cast<qsizetype>(plan.items.size()));
  EXPECT_TRUE(window_->panels().plan().shown() == plan);
}

TEST_F(PlanPanelTest, TheListFollowsPointsMeshesAndRefinement) {
  EXPECT_FALSE(rows(0).contains("attraction points"));
  bench().apply(AddPoint{bench().view.active_mesh, bench().view.crosshair_mm + Eigen::Vector3d(15, 0, 0)});
  EXPECT_TRUE(rows(0).contains("attraction points"));
  std::size_t in_memory = window_->panels().plan().shown().bytes_allocated();
  bench().apply(AddMesh{"other", Seed{bench().view.crosshair_mm, 6}, {}, 0});
  EXPECT_GT(window_->panels().plan().shown().bytes_allocated(), in_memory);
  in_memory = window_->panels().plan().shown().bytes_allocated();
  const std::uint64_t topology = bench().session().topology_revision();
  for (int n = 0; n < 200 && bench().session().topology_revision() == topology; ++n) bench().advance_steps(10);
  ASSERT_NE(bench().session().topology_revision(), topology);
  EXPECT_GT(window_->panels().plan().shown().bytes_allocated(), in_memory);
}

TEST_F(PlanPanelTest, TheListIsRebuiltOnlyWhenThePlanChanges) {
  const QTreeWidgetItem* row = list().topLevelItem(0);
  QSlider* slider = window_->panels().forces().row(ForceId::Smoothing, 0)->slider();
  for (const int position : {300, 400, 500}) slider->setValue(position);
  bench().advance_steps(5);
  EXPECT_EQ(list().topLevelItem(0), row);
}

TEST_F(PlanPanelTest, AHiddenPanelComputesNoPlan) {
  bench().apply(SetForceParameter{0, ForceId::Evidence, EvidenceForce::source, 1});
  window_->panels().show_panel("Forces");
  ASSERT_TRUE(wait_until([&] { return !window_->panels().plan().on_screen(); }));
  const StepPlan before = window_->panels().plan().shown();
  window_->panels().forces().row(ForceId::Evidence, 0)->slider()->setValue(700);
  EXPECT_TRUE(window_->panels().plan().shown() == before);
  window_->panels().show_panel("Plan");
  ASSERT_TRUE(wait_until([&] { return window_->panels().plan().on_screen(); }));
  EXPECT_TRUE(rows(0).contains("evidence targets"));
}

TEST_F(PlanPanelTest, InATallWindowThePlanIsBelowTheForces) {
  window_->panels().show_panel("Forces");
  ASSERT_TRUE(wait_until([&] { return !window_->panels().plan().on_screen(); }));
  window_->resize(1300, 1060);
  ASSERT_TRUE(wait_until([&] { return window_->panels().plan().on_screen(); }));
  EXPECT_FALSE(window_->panels().forces().visibleRegion().isEmpty());
  EXPECT_GT(window_->panels().plan().mapTo(window_.get(), QPoint()).y(),
            window_->panels().forces().mapTo(window_.get(), QPoint()).y());
  window_->resize(1200, 800);
  ASSERT_TRUE(wait_until([&] { return !window_->panels().plan().on_screen(); }));
  EXPECT_FALSE(window_->panels().forces().visibleRegion().isEmpty());
  window_->panels().show_panel("Plan");
  EXPECT_TRUE(wait_until([&] { return window_->panels().plan().on_screen(); }));
}

}  // namespace
}  // namespace simplexseg
