// SPDX-License-Identifier: Apache-2.0
// Undo in the window: it pauses the run, and the list of what was done leads anywhere in it.
#include <QDockWidget>
#include <QListWidget>

#include "gui/panels/history_panel.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class HistoryTest : public PausedPhantomTest {
 protected:
  QListWidget& list() { return *window_->history().findChild<QListWidget*>("history"); }
  void click(int row) {
    const QPointF at = list().visualItemRect(list().item(row)).center();
    QWidget& viewport = *list().viewport();
    mouse(viewport, QEvent::MouseButtonPress, at, Qt::LeftButton, Qt::LeftButton);
    mouse(viewport, QEvent::MouseButtonRelease, at, Qt::LeftButton, Qt::NoButton);
  }
};

TEST_F(HistoryTest, UndoPausesTheRun) {
  bench().run();
  bench().apply(AddPoint{scene().meshes[0].id, {0, 0, 14}});
  ASSERT_TRUE(bench().running());
  window_->actions()[Act::Undo]->trigger();
  EXPECT_FALSE(bench().running());
  EXPECT_TRUE(scene().points.empty());
  // It was not the user who paused: the next point starts it again.
  bench().apply(AddPoint{scene().meshes[0].id, {0, 0, 14}});
  EXPECT_TRUE(bench().running());
  bench().run();
  window_->actions()[Act::Undo]->trigger();
  bench().run();
  window_->actions()[Act::Redo]->trigger();
  EXPECT_FALSE(bench().running());
}

TEST_F(HistoryTest, AClickGoesThereAndBack) {
  EXPECT_FALSE(window_->history().isVisible());
  window_->actions()[Act::History]->trigger();
  QApplication::processEvents();
  ASSERT_TRUE(window_->history().isVisible());
  const ItemId mesh = scene().meshes[0].id;
  bench().pause();
  bench().apply(AddPoint{mesh, {0, 0, 14}, MarkKind::Inside});
  bench().apply(EditMesh{mesh, "kidney", {}, {}, {}});
  bench().apply(SetForceParameter{mesh, ForceId::Smoothing, 0, 0.25f});
  ASSERT_EQ(list().count(), 4);
  EXPECT_TRUE(list().item(1)->text().startsWith("add inside point: object"));
  EXPECT_TRUE(list().item(2)->text().startsWith("rename mesh: object"));
  EXPECT_TRUE(list().item(3)->text().startsWith("Smoothing, weight: kidney"));
  EXPECT_EQ(list().currentRow(), 3);
  click(1);
  EXPECT_EQ(scene().meshes[0].name, "object");
  EXPECT_EQ(scene().points.size(), 1u);
  EXPECT_EQ(list().count(), 4) << "what was taken back stays";
  EXPECT_EQ(list().currentRow(), 1);
  click(0);
  EXPECT_TRUE(scene().points.empty());
  click(3);
  EXPECT_EQ(scene().meshes[0].name, "kidney");
  EXPECT_EQ(scene().meshes[0].parameters.weight(ForceId::Smoothing), 0.25f);
  click(2);
  bench().apply(AddPoint{mesh, {0, 0, -14}});
  EXPECT_EQ(list().count(), 4);
  EXPECT_TRUE(list().item(3)->text().startsWith("add boundary point: kidney"));
  window_->actions()[Act::History]->trigger();
  EXPECT_FALSE(window_->history().isVisible());
}

}  // namespace
}  // namespace simplexseg
