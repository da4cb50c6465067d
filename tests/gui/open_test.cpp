// SPDX-License-Identifier: Apache-2.0
// Choice of a series, drops, 4D files, and cancelled loading.
#include <QAbstractButton>
#include <QDialogButtonBox>
#include <QDir>
#include <QDropEvent>
#include <QInputDialog>
#include <QLabel>
#include <QMimeData>
#include <QProgressBar>
#include <QPushButton>
#include <QSpinBox>
#include <QToolButton>
#include <QTreeWidget>
#include <QUrl>
#include <atomic>
#include <thread>

#include "../io/dicom_slices.h"
#include "gui/window/file_actions.h"
#include "gui/window/message_bar.h"
#include "gui/window/series_dialog.h"
#include "gui/workbench/background_job.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

using test::CtSlice;
using test::write_series;

class OpenTest : public WindowTest {
 protected:
  std::filesystem::path place(const char* name) const { return folder_.filePath(name).toStdString(); }
  void drop(const QList<QUrl>& urls) {
    QMimeData data;
    data.setUrls(urls);
    QDragEnterEvent enter(QPoint(300, 300), Qt::CopyAction, &data, Qt::LeftButton, Qt::NoModifier);
    QApplication::sendEvent(window_.get(), &enter);
    QDropEvent event(QPointF(300, 300), Qt::CopyAction, &data, Qt::LeftButton, Qt::NoModifier);
    QApplication::sendEvent(window_.get(), &event);
  }
  SeriesDialog* dialog() {
    return wait_until([this] { return window_->findChild<SeriesDialog*>() != nullptr; })
               ? window_->findChild<SeriesDialog*>()
               : nullptr;
  }
  static QTreeWidgetItem* row(const SeriesDialog& dialog, const QString& name) {
    auto* list = dialog.findChild<QTreeWidget*>();
    for (int n = 0; n < list->topLevelItemCount(); ++n)
      if (list->topLevelItem(n)->text(0).startsWith(name)) return list->topLevelItem(n);
    return nullptr;
  }
  static QPushButton* open_button(const SeriesDialog& dialog) {
    return dialog.findChild<QDialogButtonBox*>()->button(QDialogButtonBox::Open);
  }
};

TEST_F(OpenTest, AFolderWithOneCompleteSeriesOpensAtOnce) {
  write_series(place("one"), {}, 4);
  window_->files().open(folder_.filePath("one"));
  EXPECT_FALSE(bench().has_volume());  // in the background
  ASSERT_TRUE(wait_until([this] { return bench().has_volume(); }));
  EXPECT_EQ(window_->findChild<SeriesDialog*>(), nullptr);
  EXPECT_EQ(bench().patient_name(), "Doe, Jane");
  EXPECT_EQ(bench().series_name(), "chest");
  EXPECT_TRUE(bench().scene().volume_series.empty());
}

TEST_F(OpenTest, TheUserChoosesAmongSeveralSeries) {
  write_series(place("disc/a"), {}, 6);
  write_series(place("disc/b"), {.series = "1.2.3.2", .name = "thin", .columns = 9}, 3);
  write_series(place("disc/b"), {.series = "1.2.3.3", .name = "lost"}, 2);
  for (const char* name : {"disc/b/lost0", "disc/b/lost1"})
    std::filesystem::resize_file(place(name), std::filesystem::file_size(place(name)) - 20);
  drop({QUrl::fromLocalFile(folder_.filePath("disc"))});
  SeriesDialog* series = dialog();
  ASSERT_NE(series, nullptr);
  ASSERT_EQ(series->findChild<QTreeWidget*>()->topLevelItemCount(), 3);
  EXPECT_EQ(series->chosen()->texts.series, "chest");  // the largest
  QTreeWidgetItem* thin = row(*series, "thin");
  ASSERT_NE(thin, nullptr);
  EXPECT_TRUE(thin->text(1).contains("Doe, Jane"));
  EXPECT_TRUE(thin->text(2).contains("2024-05-31"));
  EXPECT_EQ(thin->text(3), "CT");
  EXPECT_TRUE(thin->text(4).contains("3 slices") && thin->text(4).contains("9 x 5")) << thin->text(4).toStdString();
  EXPECT_TRUE(thin->text(5).startsWith("2\n0.75 x 0.5")) << thin->text(5).toStdString();
  // The picture is not a dark square.
  const QImage picture = thin->icon(0).pixmap(64).toImage();
  EXPECT_GT(qGray(picture.pixel(50, 40)), qGray(picture.pixel(1, 1)) + 40);
  series->findChild<QTreeWidget*>()->setCurrentItem(row(*series, "lost"));
  EXPECT_FALSE(open_button(*series)->isEnabled());
  EXPECT_TRUE(open_button(*series)->toolTip().contains("truncated"));
  series->findChild<QTreeWidget*>()->setCurrentItem(thin);
  open_button(*series)->click();
  ASSERT_TRUE(wait_until([this] { return bench().has_volume(); }));
  EXPECT_EQ(bench().session().volume().geometry().size, (std::array<int, 3>{9, 5, 3}));
  EXPECT_EQ(bench().scene().volume_series, "1.2.3.2");
}

TEST_F(OpenTest, ASeriesOfOneSliceHasOneSlice) {
  write_series(place("disc/a"), {}, 6);
  write_series(place("disc/b"), {.series = "1.2.3.2", .name = "single"}, 1);
  window_->files().open(folder_.filePath("disc"));
  SeriesDialog* series = dialog();
  ASSERT_NE(series, nullptr);
  QTreeWidgetItem* single = row(*series, "single");
  ASSERT_NE(single, nullptr);
  EXPECT_TRUE(single->text(4).startsWith("1 slice\n")) << single->text(4).toStdString();
  EXPECT_TRUE(single->toolTip(0).startsWith("1 file in ")) << single->toolTip(0).toStdString();
}

TEST_F(OpenTest, DamageIsReportedBeforeAndAfterLoading) {
  write_series(place("cut"), {}, 8);
  std::filesystem::resize_file(place("cut/chest7"), std::filesystem::file_size(place("cut/chest7")) - 20);
  window_->files().open(folder_.filePath("cut"));
  SeriesDialog* series = dialog();
  ASSERT_NE(series, nullptr);
  EXPECT_TRUE(row(*series, "chest")->text(0).contains("damaged"));
  bool reported = false;
  for (const QLabel* label : series->findChildren<QLabel*>()) reported |= label->text().contains("only 7 of 8");
  EXPECT_TRUE(reported);
  open_button(*series)->click();
  ASSERT_TRUE(wait_until([this] { return bench().has_volume(); }));
  EXPECT_EQ(bench().session().volume().geometry().size[2], 7);
  EXPECT_TRUE(window_->messages().text().contains("only 7 of 8")) << window_->messages().text().toStdString();
}

TEST_F(OpenTest, FilesDroppedTogetherAreASeries) {
  write_series(place("files"), {}, 3);
  QList<QUrl> urls;
  for (const char* name : {"files/chest0", "files/chest1", "files/chest2"})
    urls << QUrl::fromLocalFile(folder_.filePath(name));
  drop(urls);
  ASSERT_TRUE(wait_until([this] { return bench().has_volume(); }));
  EXPECT_EQ(bench().session().volume().geometry().size[2], 3);
}

TEST_F(OpenTest, TheVolumeOfA4dFileIsChosen) {
  test::EnhancedFile file;
  for (int time = 1; time <= 3; ++time)
    for (int k = 0; k < 4; ++k) file.frames.push_back({.position = {0, 0, 2.0 * k}, .value = 100 * time, .time = time});
  std::ofstream(place("four.dcm"), std::ios::binary) << file.bytes();
  window_->files().open(folder_.filePath("four.dcm"));
  ASSERT_TRUE(wait_until([this] { return window_->findChild<QInputDialog*>("volume_dialog") != nullptr; }));
  auto* input = window_->findChild<QInputDialog*>("volume_dialog");
  EXPECT_EQ(input->intMaximum(), 3);
  input->setIntValue(2);
  input->accept();
  ASSERT_TRUE(wait_until([this] { return bench().has_volume(); }));
  EXPECT_EQ(bench().session().volume().value(0, 0, 0), 200);
  EXPECT_EQ(bench().scene().volume_number, 2);
}

TEST_F(OpenTest, LoadingCanBeCancelledAndTheOpenSceneStays) {
  open_phantom();
  auto* job = window_->findChild<BackgroundJob*>();
  std::atomic<bool> ended = false;
  ASSERT_TRUE(job->start(
      "Loading...",
      [&ended] {
        struct End {
          std::atomic<bool>& ended;
          ~End() { ended = true; }
        } end{ended};
        for (;;) {
          report_progress(3, 4);
          std::this_thread::yield();
        }
      },
      [] { FAIL(); }, BackgroundJob::Cancellable::Yes));
  auto* bar = window_->messages().findChild<QProgressBar*>();
  EXPECT_TRUE(wait_until([bar] { return bar->maximum() > 0 && 4 * bar->value() == 3 * bar->maximum(); }));
  auto* cancel = window_->messages().findChild<QToolButton*>("cancel_loading");
  ASSERT_TRUE(cancel->isVisible());
  cancel->click();
  EXPECT_FALSE(job->busy());
  EXPECT_FALSE(window_->messages().isVisible());
  EXPECT_TRUE(wait_until([&ended] { return ended.load(); }));
  EXPECT_EQ(scene().meshes.size(), 1u);
  // Another file can be opened at once.
  write_series(place("one"), {}, 4);
  window_->files().open(folder_.filePath("one"));
  EXPECT_TRUE(wait_until([this] { return bench().session().volume().geometry().size[2] == 4; }));
}

}  // namespace
}  // namespace simplexseg
