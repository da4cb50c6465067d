// SPDX-License-Identifier: Apache-2.0
// Undo pauses the simulation; the history panel restores any state.
#include <QDockWidget>
#include <QListWidget>

#include "gui/panels/history_panel.h"
#include "gui/window/file_actions.h"
#include "gui/window/message_bar.h"
#include "io/volume/volume_io.h"
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
  // The user did not pause: the next point starts the run again.
  bench().apply(AddPoint{scene().meshes[0].id, {0, 0, 14}});
  EXPECT_TRUE(bench().running());
  bench().run();
  window_->actions()[Act::Undo]->trigger();
  bench().run();
  window_->actions()[Act::Redo]->trigger();
  EXPECT_FALSE(bench().running());
}

TEST_F(HistoryTest, AClickGoesToAnActionInBothDirections) {
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
  EXPECT_TRUE(list().item(2)->text().startsWith("rename segmentation: object"));
  EXPECT_TRUE(list().item(3)->text().startsWith("Smoothing, weight: kidney"));
  EXPECT_EQ(list().currentRow(), 3);
  click(1);
  EXPECT_EQ(scene().meshes[0].name, "object");
  EXPECT_EQ(scene().points.size(), 1u);
  EXPECT_EQ(list().count(), 4) << "undone actions stay listed";
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

TEST_F(HistoryTest, ASavedSceneOpensWithItsUndoHistory) {
  const std::string image = folder_.filePath("ball.nii").toStdString();
  write_volume(image, make_phantom("sphere", {}).image);
  window_->files().open_loaded(load_input(image), image);
  bench().pause();
  ItemId mesh = 0;
  bench().apply(AddMesh{"object", Seed{bench().view.crosshair_mm, 9}, {}, 0}, &mesh);
  bench().pause();
  std::vector<std::vector<Eigen::Vector3f>> poses;
  const auto do_one = [&](const Command& command) {
    poses.push_back(scene().meshes[0].mesh.positions);
    bench().apply(command);
    bench().pause();
    bench().advance_steps(4);
  };
  do_one(AddPoint{mesh, bench().view.crosshair_mm + Eigen::Vector3d(0, 0, 13)});
  do_one(SetForceParameter{mesh, ForceId::Smoothing, 0, 0.25f});
  do_one(EditMesh{mesh, "kidney", {}, {}, {}});
  poses.push_back(scene().meshes[0].mesh.positions);
  window_->actions()[Act::Undo]->trigger();
  window_->actions()[Act::History]->trigger();
  QApplication::processEvents();
  const auto rows = [&] {
    QStringList texts;
    for (int row = 0; row < list().count(); ++row) texts << list().item(row)->text();
    return texts;
  };
  const QStringList names = rows();
  ASSERT_EQ(names.size(), 5);
  const QString scene_file = folder_.filePath("mine.json");
  ASSERT_TRUE(window_->files().save_scene_to(scene_file));
  EXPECT_EQ(rows(), names) << "saving changes nothing here";

  open_phantom();
  EXPECT_EQ(list().count(), 1);
  window_->files().open(scene_file);
  ASSERT_TRUE(wait_until([&] { return bench().session().can_undo(); })) << window_->messages().text().toStdString();
  EXPECT_EQ(rows(), names);
  EXPECT_FALSE(bench().has_unsaved_changes());
  EXPECT_EQ(scene().meshes[0].mesh.positions, poses[2]);
  window_->actions()[Act::Redo]->trigger();
  EXPECT_EQ(scene().meshes[0].name, "kidney");
  EXPECT_EQ(scene().meshes[0].mesh.positions, poses[3]);
  for (int n = 2; n >= 0; --n) {
    window_->actions()[Act::Undo]->trigger();
    EXPECT_EQ(scene().meshes[0].mesh.positions, poses[static_cast<std::size_t>(n)]) << n;
  }
  EXPECT_TRUE(scene().points.empty());
  click(0);  // to the state before the mesh was added
  EXPECT_TRUE(scene().meshes.empty());
  click(4);
  EXPECT_EQ(scene().meshes[0].mesh.positions, poses[3]);
  // A new action follows the earlier ones.
  bench().apply(AddPoint{scene().meshes[0].id, bench().view.crosshair_mm, MarkKind::Inside});
  EXPECT_TRUE(list().item(list().count() - 1)->text().startsWith("add inside point: kidney"));
  EXPECT_EQ(list().count(), 6);

  // A damaged history is reported in one line, and the scene opens.
  QFile history(folder_.filePath("mine.history"));
  ASSERT_TRUE(history.open(QIODevice::ReadWrite));
  ASSERT_TRUE(history.resize(history.size() / 2));
  history.close();
  bench().mark_saved();
  open_phantom();
  window_->files().open(scene_file);
  ASSERT_TRUE(
      wait_until([&] { return window_->files().scene_path() == scene_file && bench().scene().points.size() == 1; }));
  EXPECT_TRUE(window_->messages().text().contains("the undo history")) << window_->messages().text().toStdString();
  EXPECT_FALSE(bench().session().can_undo());
}

}  // namespace
}  // namespace simplexseg
