// SPDX-License-Identifier: Apache-2.0
// Opening, dropping and saving files in the window.
#include <QDir>
#include <QDropEvent>
#include <QFile>
#include <QMenu>
#include <QMimeData>
#include <QSettings>
#include <QUrl>

#include "gpu/backend.h"
#include "gui/window/file_actions.h"
#include "gui/window/message_bar.h"
#include "gui/window/window_memory.h"
#include "gui/workbench/background_job.h"
#include "io/mesh/mesh_io.h"
#include "io/volume/volume_io.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class WindowFilesTest : public WindowTest {
 protected:
  QString path(const char* name) const { return folder_.filePath(name); }
  void write(const char* name, const QByteArray& bytes) const {
    QFile file(path(name));
    ASSERT_TRUE(file.open(QIODevice::WriteOnly));
    file.write(bytes);
  }
  void drop(const QList<QUrl>& urls) {
    QMimeData data;
    data.setUrls(urls);
    QDragEnterEvent enter(QPoint(300, 300), Qt::CopyAction, &data, Qt::LeftButton, Qt::NoModifier);
    QApplication::sendEvent(window_.get(), &enter);  // Qt delivers a drop only after the drag has entered
    QDropEvent event(QPointF(300, 300), Qt::CopyAction, &data, Qt::LeftButton, Qt::NoModifier);
    QApplication::sendEvent(window_.get(), &event);
  }
  void write_phantom(const char* name) const { write_volume(path(name).toStdString(), make_phantom("cube", {}).image); }
};

TEST_F(WindowFilesTest, AVolumeOpensInTheBackground) {
  write_phantom("cube.nii.gz");
  window_->files().open(path("cube.nii.gz"));
  EXPECT_FALSE(bench().has_volume());  // the call returns before the file is read
  ASSERT_TRUE(wait_until([&] { return bench().has_volume(); }));
  EXPECT_EQ(bench().session().volume().geometry().size[0], 64);
  EXPECT_TRUE(window_->windowTitle().contains("cube.nii.gz"));
  EXPECT_FALSE(bench().has_unsaved_changes());
}

TEST_F(WindowFilesTest, NoDroppedItemDoesHarm) {
  open_phantom();
  write("text.nii", "this is not a volume");
  write("empty.nii.gz", "");
  write("broken.json", "{ \"meshes\": [");
  write("strange.json", "{\"simplexseg_scene\": 1, \"colour\": 7}");
  ASSERT_TRUE(QDir(folder_.path()).mkdir("folder"));
  for (const char* name : {"text.nii", "empty.nii.gz", "broken.json", "strange.json", "folder", "missing.mha"}) {
    window_->messages().clear();
    drop({QUrl::fromLocalFile(path(name))});
    ASSERT_TRUE(wait_until([&] {
      return window_->messages().isVisible() && !window_->messages().text().contains("Loading");
    })) << name;
    EXPECT_FALSE(window_->messages().text().contains('\n')) << name;
    EXPECT_EQ(scene().meshes.size(), 1u) << name;  // the open scene stays
  }
  drop({QUrl("https://example.org/volume.nii")});
  drop({});
  EXPECT_EQ(scene().meshes.size(), 1u);
}

TEST_F(WindowFilesTest, ADroppedVolumeOpens) {
  write_phantom("cube.nii");
  drop({QUrl::fromLocalFile(path("cube.nii"))});
  EXPECT_TRUE(wait_until([&] { return bench().has_volume(); }));
}

TEST_F(WindowFilesTest, ASavedSceneIsRestoredExactly) {
  write_phantom("cube.nii.gz");
  window_->files().open_loaded(load_input(path("cube.nii.gz").toStdString()), path("cube.nii.gz").toStdString());
  bench().apply(AddMesh{"ball", Seed{bench().view.crosshair_mm, 9}, Colour{10, 200, 30}, 0});
  bench().apply(AddPoint{bench().view.active_mesh, bench().view.crosshair_mm + Eigen::Vector3d(12, 0, 0)});
  bench().pause();
  bench().advance_steps(7);
  EXPECT_TRUE(bench().has_unsaved_changes());
  ASSERT_TRUE(window_->files().save_scene_to(path("scene.json"))) << window_->messages().text().toStdString();
  EXPECT_FALSE(bench().has_unsaved_changes());
  const std::vector<Eigen::Vector3f> positions = scene().meshes[0].mesh.positions;
  const LoadedInput again = load_input(path("scene.json").toStdString());
  ASSERT_EQ(again.scene.meshes.size(), 1u);
  EXPECT_EQ(again.scene.meshes[0].mesh.positions, positions);
  EXPECT_EQ(again.scene.meshes[0].colour, (Colour{10, 200, 30}));
  EXPECT_EQ(again.scene.points.size(), 1u);
  EXPECT_FALSE(again.volume.empty());
}

TEST_F(WindowFilesTest, TheTitleMarksUnsavedChanges) {
  write_phantom("cube.nii.gz");
  window_->files().open_loaded(load_input(path("cube.nii.gz").toStdString()), path("cube.nii.gz").toStdString());
  EXPECT_FALSE(window_->isWindowModified());
  EXPECT_TRUE(window_->windowTitle().contains("cube.nii.gz[*]")) << window_->windowTitle().toStdString();
  bench().apply(AddMesh{"ball", Seed{bench().view.crosshair_mm, 9}, {}, 0});
  bench().pause();
  EXPECT_TRUE(window_->isWindowModified());
  ASSERT_TRUE(window_->files().save_scene_to(path("scene.json")));
  EXPECT_FALSE(window_->isWindowModified());
  bench().advance_steps(1);
  EXPECT_TRUE(window_->isWindowModified());
}

TEST_F(WindowFilesTest, MeshesWithoutAColourGetDifferentOnes) {
  write_phantom("cube.nii");
  const QString mesh = R"({"name": "%1", "sphere": {"centre_mm": [0, 0, 0], "radius_mm": 8}%2})";
  const QString first = mesh.arg("a", ""), second = mesh.arg("b", R"(, "colour": "#56b4e9")");
  write("scene.json", (R"({"simplexseg_scene": 1, "volume": "cube.nii", "meshes": [)" + first + ", " + second + ", " +
                       mesh.arg("c", "") + ", " + mesh.arg("d", "") + "]}")
                          .toUtf8());
  window_->files().open_loaded(load_input(path("scene.json").toStdString()), path("scene.json").toStdString());
  const std::vector<MeshItem>& meshes = scene().meshes;
  ASSERT_EQ(meshes.size(), 4u);
  EXPECT_EQ(meshes[1].colour, (Colour{0x56, 0xb4, 0xe9}));
  for (std::size_t a = 0; a < meshes.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) EXPECT_NE(meshes[a].colour, meshes[b].colour) << a << b;
}

TEST_F(WindowFilesTest, WhatCannotBeSavedIsReportedAtOnce) {
  open_phantom();
  for (const char* name : {"no/such/folder/labels.nii.gz", "labels.unknown", "labels.dcm"}) {
    window_->messages().clear();
    window_->files().save_labels_to(path(name));
    EXPECT_FALSE(window_->job().busy()) << name;
    EXPECT_TRUE(window_->messages().isVisible()) << name;
  }
}

TEST_F(WindowFilesTest, SavingToAnInvalidPathShowsAMessage) {
  open_phantom();
  EXPECT_FALSE(window_->files().save_scene_to(path("no/such/folder/scene.json")));
  EXPECT_TRUE(window_->messages().isVisible());
  window_->messages().clear();
  window_->files().save_labels_to(path("no/such/folder/labels.nii.gz"));
  EXPECT_TRUE(
      wait_until([&] { return window_->messages().isVisible() && !window_->messages().text().contains("..."); }));
}

TEST_F(WindowFilesTest, SuggestedNamesCombineVolumeAndSceneAndAreUnused) {
  write_phantom("cube.nii.gz");
  write("labels.nii.gz", "a reference");
  window_->files().open_loaded(load_input(path("cube.nii.gz").toStdString()), path("cube.nii.gz").toStdString());
  EXPECT_EQ(window_->files().suggested_path("-labels", ".nii.gz"), path("cube-labels.nii.gz"));
  EXPECT_EQ(window_->files().suggested_path("", ".simplexseg.json"), path("cube.simplexseg.json"));
  write("cube-labels.nii.gz", "another");
  EXPECT_EQ(window_->files().suggested_path("-labels", ".nii.gz"), path("cube-labels-2.nii.gz"));
  write("cube-labels-2.nii.gz", "a third");
  EXPECT_EQ(window_->files().suggested_path("-labels", ".nii.gz"), path("cube-labels-3.nii.gz"));
  ASSERT_TRUE(window_->files().save_scene_to(path("kidneys.simplexseg.json")));
  EXPECT_EQ(window_->files().suggested_path("-labels", ".nii.gz"), path("cube-kidneys-labels.nii.gz"));
}

TEST_F(WindowFilesTest, TheWindowRemembersFilesContrastAndSize) {
  QSettings::setPath(QSettings::IniFormat, QSettings::UserScope, folder_.filePath("settings"));
  write_phantom("cube.nii.gz");
  write_phantom("other.nii.gz");
  const auto open = [&](const char* name) {
    window_->files().open_loaded(load_input(path(name).toStdString()), path(name).toStdString());
  };
  {
    WindowMemory memory(*window_);
    EXPECT_FALSE(window_->recent_menu()->isEnabled());
    open("cube.nii.gz");
    bench().view.window = 123, bench().view.level = 45;
    bench().view_edited();
    open("other.nii.gz");
    EXPECT_NE(bench().view.window, 123);
    window_->resize(1000, 700);
    QApplication::processEvents();
  }
  show_window(make_engine(Backend::Cpu).engine, {});
  WindowMemory memory(*window_);
  EXPECT_TRUE(memory.restore_geometry());
  EXPECT_EQ(window_->size(), QSize(1000, 700));
  EXPECT_EQ(memory.recent(), (QStringList{path("other.nii.gz"), path("cube.nii.gz")}));
  ASSERT_EQ(window_->recent_menu()->actions().size(), 2);
  window_->recent_menu()->actions()[1]->trigger();
  ASSERT_TRUE(wait_until([&] { return bench().has_volume(); }));
  EXPECT_EQ(bench().view.window, 123);
  EXPECT_EQ(bench().view.level, 45);
}

TEST_F(WindowFilesTest, LabelsAndMeshesAreWritten) {
  open_phantom(12);
  window_->files().save_labels_to(path("labels.nii.gz"));
  ASSERT_TRUE(wait_until([&] { return window_->messages().text().startsWith("Saved"); }));
  const Volume labels = read_volume(path("labels.nii.gz").toStdString());
  EXPECT_TRUE(labels.geometry().same_grid(bench().session().volume().geometry()));
  int inside = 0;
  for (int k = 0; k < 64; ++k)
    for (int j = 0; j < 64; ++j)
      for (int i = 0; i < 64; ++i) inside += labels.value(i, j, k) == scene().meshes[0].label;
  EXPECT_NEAR(inside, 4.0 / 3 * 3.14159 * 12 * 12 * 12, 350);
  window_->messages().clear();
  window_->files().save_meshes_to(folder_.path());
  ASSERT_TRUE(wait_until([&] { return window_->messages().text().startsWith("Saved"); }));
  EXPECT_EQ(read_mesh(path("object.ply").toStdString()).positions, scene().meshes[0].mesh.positions);
  window_->messages().clear();
  window_->files().save_surfaces_to(path("case.glb"));
  ASSERT_TRUE(wait_until([&] { return window_->messages().text().startsWith("Saved"); }));
  QFile file(path("case.glb"));
  ASSERT_TRUE(file.open(QIODevice::ReadOnly));
  EXPECT_TRUE(file.read(4) == "glTF");
}

TEST_F(WindowFilesTest, ThePictureHasTheWindowsSize) {
  open_phantom();
  window_->save_picture(path("picture.png"));
  const QImage picture(path("picture.png"));
  EXPECT_EQ(picture.size(), window_->size() * window_->devicePixelRatio());
  EXPECT_ANY_THROW(window_->save_picture(path("no/such/folder/picture.png")));
}

}  // namespace
}  // namespace simplexseg
