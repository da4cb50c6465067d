// SPDX-License-Identifier: Apache-2.0
// Cancellation of the field that is being solved, in the window. The key Esc is tested in keys_test.cpp.
#include <QAction>
#include <QLabel>
#include <QTest>
#include <QToolButton>

#include "forces/evidence.h"
#include "gui/panels/mesh_card.h"
#include "gui/panels/mesh_panel.h"
#include "gui/window/message_bar.h"
#include "gui/workbench/frame_loop.h"
#include "io/scene/log_io.h"
#include "session/mesh_marks.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class CancelTest : public PausedPhantomTest {
 protected:
  void SetUp() override {
    PausedPhantomTest::SetUp();
    if (IsSkipped()) return;
    bench().apply(SetForceParameter{0, ForceId::Evidence, EvidenceForce::weight, 1});
    bench().apply(SetForceParameter{0, ForceId::Evidence, EvidenceForce::source, 0});
    bench().advance_steps(1);
    first_ = scene().meshes[0].field;
    ASSERT_TRUE(first_);
  }
  /// Adds an outside point and starts the update of the field. The simulation is paused, so no frame commits it.
  void start_update() {
    bench().apply(
        AddPoint{bench().view.active_mesh, bench().view.crosshair_mm + Eigen::Vector3d(14, 0, 0), MarkKind::Outside});
    bench().advance(0.001);
    ASSERT_EQ(solving(), bench().view.active_mesh);
  }
  ItemId solving() { return bench().session().solving_mesh(); }
  bool last_is_cancel() { return std::holds_alternative<CancelFieldUpdate>(bench().session().log().back().command); }
  QToolButton* button(const char* name) {
    return window_->findChild<MeshPanel*>()->cards()[0]->findChild<QToolButton*>(name);
  }
  QStringList card_texts() {
    QStringList texts;
    for (const QLabel* label : window_->findChild<MeshPanel*>()->cards()[0]->findChildren<QLabel*>())
      texts << label->text();
    return texts;
  }

  std::shared_ptr<const MeshField> first_;  ///< field before the update
};

TEST_F(CancelTest, TheCardHasButtonsThatCancelAndSolve) {
  QToolButton *const cancel = button("cancel_solving"), *const solve = button("solve");
  ASSERT_TRUE(cancel && solve);
  EXPECT_FALSE(cancel->isVisible());
  EXPECT_FALSE(solve->isVisible());
  start_update();
  ASSERT_TRUE(wait_until([&] { return cancel->isVisible(); }));
  EXPECT_EQ(cancel->toolTip(), "Cancel (Esc)");
  QTest::mouseClick(cancel, Qt::LeftButton);
  EXPECT_EQ(solving(), 0u);
  EXPECT_TRUE(last_is_cancel());
  EXPECT_EQ(scene().meshes[0].field, first_);
  EXPECT_TRUE(window_->messages().text().startsWith("Update cancelled. The segmentation is that before the last mark."))
      << window_->messages().text().toStdString();
  ASSERT_TRUE(wait_until([&] { return solve->isVisible() && !cancel->isVisible(); }));
  EXPECT_TRUE(card_texts().contains("marks pending")) << card_texts().join(", ").toStdString();

  bench().run();
  for (int n = 0; n < 10; ++n) window_->loop().tick();
  EXPECT_EQ(solving(), 0u) << "it does not start again";
  EXPECT_EQ(scene().meshes[0].field, first_);
  bench().pause();
  QTest::mouseClick(solve, Qt::LeftButton);
  EXPECT_TRUE(bench().running());
  ASSERT_TRUE(wait_until([&] { return scene().meshes[0].field != first_; }));
  EXPECT_EQ(scene().meshes[0].field->marks.size(), 2u);
  bench().pause();
  EXPECT_TRUE(wait_until([&] { return !solve->isVisible() && !card_texts().contains("marks pending"); }));
}

TEST_F(CancelTest, TheMenuEntryIsEnabledWhileAFieldIsSolved) {
  QAction* const entry = window_->actions()[Act::CancelSolving];
  EXPECT_FALSE(entry->isEnabled());
  EXPECT_TRUE(entry->toolTip().contains("No segmentation")) << entry->toolTip().toStdString();
  start_update();
  EXPECT_TRUE(entry->isEnabled());
  entry->trigger();
  EXPECT_EQ(solving(), 0u);
  EXPECT_FALSE(entry->isEnabled());
}

TEST_F(CancelTest, UndoStopsTheUpdateOfThePoint) {
  start_update();
  window_->actions()[Act::Undo]->trigger();
  EXPECT_EQ(solving(), 0u);
  EXPECT_TRUE(last_is_cancel());
  EXPECT_TRUE(scene().points.empty());
  EXPECT_EQ(scene().meshes[0].field, first_);
  EXPECT_FALSE(card_texts().contains("marks pending"));
}

TEST_F(CancelTest, DeletionStopsTheUpdate) {
  start_update();
  window_->actions()[Act::DeleteMesh]->trigger();
  EXPECT_TRUE(scene().meshes.empty());
  EXPECT_EQ(solving(), 0u);
  EXPECT_TRUE(last_is_cancel());
}

TEST_F(CancelTest, TheLogContainsTheCommands) {
  start_update();
  bench().cancel_solving();
  bench().solve(bench().view.active_mesh);
  bench().pause();
  const std::vector<LogEntry>& log = bench().session().log();
  const std::string path = folder_.filePath("log.json").toStdString();
  write_log(path, log, 0, "");
  const LogFile file = read_log(path);
  ASSERT_EQ(file.log.size(), log.size());
  std::size_t cancels = 0, requests = 0;
  for (std::size_t n = 0; n < log.size(); ++n) {
    EXPECT_EQ(file.log[n].command.index(), log[n].command.index()) << n;
    cancels += std::holds_alternative<CancelFieldUpdate>(file.log[n].command);
    if (const auto* request = std::get_if<RequestFieldUpdate>(&file.log[n].command)) {
      ++requests;
      EXPECT_EQ(request->mesh, bench().view.active_mesh);
    }
  }
  EXPECT_EQ(cancels, 1u);
  EXPECT_EQ(requests, 1u);
}

}  // namespace
}  // namespace simplexseg
