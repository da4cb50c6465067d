// SPDX-License-Identifier: Apache-2.0
// Files whose names are not UTF-8: the window opens and writes what the command line does.
#include <QMimeData>
#include <QSettings>
#include <QUrl>
#include <cstdlib>
#include <filesystem>
#include <random>

#include "gui/look/qt_text.h"
#include "gui/window/file_actions.h"
#include "gui/window/message_bar.h"
#include "gui/window/window_memory.h"
#include "gui/workbench/background_job.h"
#include "io/volume/volume_io.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {
namespace fs = std::filesystem;

TEST(PathText, EveryByteSurvives) {
  std::mt19937 random(1);
  for (const std::string bytes : {"plain", "M\xC3\xBCller", "M\xFCller", "\xE9", "\xF0\x9F\x92\x80", "\xED\xB3\xA9",
                                  "\xE2\x82", "\xC3(", "\xFF\xFE\xC0\x80"}) {
    EXPECT_EQ(to_path(text(fs::path(bytes))).native(), bytes);
  }
  for (int n = 0; n < 2000; ++n) {
    std::string bytes;
    for (std::size_t length = 1 + random() % 12; bytes.size() < length;) bytes += static_cast<char>(1 + random() % 255);
    EXPECT_EQ(to_path(text(fs::path(bytes))).native(), bytes);
  }
}

TEST(PathText, OnlyUtf8IsUtf8) {
  for (const char* name : {"plain", "M\xC3\xBCller", "\xF0\x9F\x92\x80"}) EXPECT_TRUE(is_utf8(fs::path(name)));
  for (const char* name : {"M\xFCller", "\xED\xB3\xA9", "\xE2\x82"}) EXPECT_FALSE(is_utf8(fs::path(name)));
}

class PathsTest : public WindowTest {
 protected:
  void SetUp() override {
    WindowTest::SetUp();
    if (IsSkipped()) return;
    write_volume(file_, make_phantom("sphere", {}).image);
  }
  const fs::path root_ = folder_.path().toStdString();
  const fs::path file_ = root_ / "b\xE9ll.nii";
};

TEST_F(PathsTest, AVolumeOpensAndItsLabelsAreWritten) {
  window_->files().open(text(file_));
  ASSERT_TRUE(wait_until([this] { return bench().has_volume(); })) << window_->messages().text().toStdString();
  EXPECT_EQ(to_path(window_->files().path()), file_);
  EXPECT_TRUE(window_->messages().text().contains("not UTF-8")) << "no scene can be saved";
  bench().apply(AddMesh{"ball", Seed{bench().view.crosshair_mm, 9}, {}, 0});
  bench().pause();
  const fs::path labels = root_ / "l\xE9.nii.gz", picture = root_ / "p\xE9.png";
  window_->files().save_labels_to(text(labels));
  ASSERT_TRUE(wait_until([this] { return !window_->job().busy(); }));
  EXPECT_TRUE(fs::exists(labels)) << window_->messages().text().toStdString();
  window_->save_picture(text(picture));
  EXPECT_TRUE(fs::exists(picture));
}

TEST_F(PathsTest, ADroppedVolumeOpens) {
  const QUrl url = url_of(text(file_));
  EXPECT_TRUE(url.toEncoded().contains("b%E9ll.nii")) << url.toEncoded().toStdString();
  EXPECT_EQ(to_path(local_path(url)), file_);
  QMimeData data;
  data.setUrls({url});
  EXPECT_EQ(FileActions::dropped_paths(&data), QStringList{text(file_)});
  window_->files().open_all(FileActions::dropped_paths(&data));
  EXPECT_TRUE(wait_until([this] { return bench().has_volume(); }));
}

TEST_F(PathsTest, TheVolumeIsARecentFile) {
  QSettings::setPath(QSettings::IniFormat, QSettings::UserScope, folder_.filePath("settings"));
  {
    WindowMemory memory(*window_);
    window_->files().open(text(file_));
    ASSERT_TRUE(wait_until([this] { return bench().has_volume(); }));
  }
  WindowMemory memory(*window_);
  EXPECT_EQ(memory.recent(), QStringList{text(file_)});
}

TEST_F(PathsTest, TheProgramOpensItFromTheCommandLine) {
  const fs::path picture = root_ / "p\xE9.png";
  const std::string command = "'" SIMPLEXSEG_PROGRAM "' --backend cpu --steps 0 --screenshot '" + picture.native() +
                              "' '" + file_.native() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  EXPECT_TRUE(fs::exists(picture));
}

}  // namespace
}  // namespace simplexseg
