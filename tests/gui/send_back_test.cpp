// SPDX-License-Identifier: Apache-2.0
// Sending results to an archive.
#include <QAction>
#include <QCheckBox>
#include <QComboBox>
#include <QProgressBar>

#include "archive_fixture.h"
#include "gui/window/file_actions.h"
#include "gui/window/message_bar.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

constexpr const char* kSegmentation = "1.2.840.10008.5.1.4.1.1.66.4";
constexpr const char* kStructureSet = "1.2.840.10008.5.1.4.1.1.481.3";
constexpr const char* kLabelMapClass = "1.2.840.10008.5.1.4.1.1.66.7";
constexpr const char* kReportClass = "1.2.840.10008.5.1.4.1.1.88.34";
constexpr const char* kCapture = "1.2.840.10008.5.1.4.1.1.7";

class SendBackTest : public ArchiveFixture {};

TEST_F(SendBackTest, WithoutADicomImageSendingIsDisabledWithAReason) {
  QAction* const action = window_->actions()[Act::SendBack];
  EXPECT_FALSE(action->isEnabled());
  EXPECT_EQ(action->toolTip(), "Open a DICOM image first");
  open_dicom_with_mesh();
  EXPECT_TRUE(action->isEnabled());
  const std::string file = folder_.filePath("ball.nii.gz").toStdString();
  write_volume(file, make_phantom("sphere", {.size = 16}).image);
  bench().mark_saved();
  window_->files().open(folder_.filePath("ball.nii.gz"));
  ASSERT_TRUE(wait_until([this] { return bench().session().volume().geometry().size[0] == 16; }));
  EXPECT_FALSE(action->isEnabled());
  EXPECT_TRUE(action->toolTip().contains("not DICOM")) << action->toolTip().toStdString();
}

TEST_F(SendBackTest, LabelsContoursAndThePictureBecomeSeriesOfTheStudy) {
  write_two_servers();
  open_dicom_with_mesh();
  SendDialog* dialog = send_dialog();
  ASSERT_NE(dialog, nullptr);
  click(*dialog, "send_button");
  ASSERT_TRUE(wait_until([this] { return window_->findChild<SendDialog*>() == nullptr; }));
  EXPECT_EQ(fake_.server, "one");
  ASSERT_EQ(fake_.sent.size(), 3u);
  std::vector<std::string> classes;
  for (const DicomIdentity& one : fake_.sent) {
    classes.push_back(one.sop_class);
    EXPECT_EQ(one.study, FakeArchive::kStudy);
    EXPECT_NE(one.series, FakeArchive::kSeries);
  }
  EXPECT_EQ(classes, (std::vector<std::string>{kSegmentation, kStructureSet, kCapture}));
  EXPECT_TRUE(fake_.sent_bytes[0].find("ball") != std::string::npos) << "the segment has the name of the mesh";
  EXPECT_GT(fake_.sent_bytes[2].size(), 100'000u) << "the pixels of the views";
  EXPECT_TRUE(cached().empty()) << "no file stays on the disk";
  EXPECT_EQ(window_->messages().text(), "Sent 3 series to one");
}

TEST_F(SendBackTest, OnlyTickedItemsAreSentAndWarningsOfTheArchiveAreShown) {
  write_two_servers();
  open_dicom_with_mesh();
  SendDialog* dialog = send_dialog();
  ASSERT_NE(dialog, nullptr);
  for (const char* box : {"send_labels", "send_contours", "send_view"}) click(*dialog, box);
  auto* send = dialog->findChild<QPushButton*>("send_button");
  EXPECT_FALSE(send->isEnabled());
  EXPECT_EQ(send->toolTip(), "Select an item to send");
  click(*dialog, "send_contours");
  QTest::keyClick(dialog->findChild<QComboBox*>("send_server"), Qt::Key_Down);
  fake_.warnings = {"it changed the patient's id"};
  click(*dialog, "send_button");
  ASSERT_TRUE(wait_until([this] { return window_->findChild<SendDialog*>() == nullptr; }));
  EXPECT_EQ(fake_.server, "two");
  ASSERT_EQ(fake_.sent.size(), 1u);
  EXPECT_EQ(fake_.sent[0].sop_class, kStructureSet);
  EXPECT_TRUE(window_->messages().text().contains("it changed the patient's id"));
}

TEST_F(SendBackTest, AReportIsSentWithTheSegmentationToWhichItRefers) {
  write_two_servers();
  open_dicom_with_mesh();
  SendDialog* dialog = send_dialog();
  ASSERT_NE(dialog, nullptr);
  EXPECT_FALSE(dialog->findChild<QCheckBox*>("send_report")->isChecked());
  for (const char* box : {"send_contours", "send_view", "send_report"}) click(*dialog, box);
  fake_.fault = "the archive one: time-out";
  click(*dialog, "send_button");
  ASSERT_TRUE(wait_until([&] { return !dialog->task().busy(); }));
  if (dialog->task().text().contains("without DCMTK")) GTEST_SKIP() << "no structured reports in this build";
  ASSERT_EQ(fake_.sent.size(), 2u) << dialog->task().text().toStdString();
  EXPECT_EQ(fake_.sent[0].sop_class, kSegmentation);
  EXPECT_EQ(fake_.sent[1].sop_class, kReportClass);
  EXPECT_EQ(fake_.sent[1].study, FakeArchive::kStudy);
  EXPECT_TRUE(fake_.sent_bytes[1].find(fake_.sent[0].sop_instance) != std::string::npos);
  // A label map of these labels is sent beside them, without the binary segmentation of its own.
  const std::string instance = fake_.sent[0].sop_instance;
  fake_.fault.clear();
  QTest::keyClick(dialog->findChild<QComboBox*>("send_encoding"), Qt::Key_Down);
  click(*dialog, "send_button");
  ASSERT_TRUE(wait_until([this] { return window_->findChild<SendDialog*>() == nullptr; }));
  ASSERT_EQ(fake_.sent.size(), 3u);
  EXPECT_EQ(fake_.sent[0].sop_instance, instance) << "sent again, not written again";
  EXPECT_EQ(fake_.sent[1].sop_class, kReportClass);
  EXPECT_EQ(fake_.sent[2].sop_class, kLabelMapClass);
  EXPECT_EQ(window_->messages().text(), "Sent 3 series to one");
}

TEST_F(SendBackTest, AReportOfEqualLabelsIsRefusedInOneLine) {
  write_two_servers();
  open_dicom_with_mesh();
  bench().apply(AddMesh{"second", Seed{bench().session().volume().geometry().centre_mm(), 3}, {}, 0});
  EditMesh same{};
  same.mesh = scene().meshes[1].id, same.label = scene().meshes[0].label;
  bench().apply(same);
  bench().pause();
  SendDialog* dialog = send_dialog();
  ASSERT_NE(dialog, nullptr);
  click(*dialog, "send_report");
  click(*dialog, "send_button");
  ASSERT_TRUE(wait_until([&] { return !dialog->task().busy(); }));
  if (dialog->task().text().contains("without DCMTK")) GTEST_SKIP() << "no structured reports in this build";
  EXPECT_TRUE(dialog->task().text().contains("two segmentations have the label"))
      << dialog->task().text().toStdString();
  EXPECT_TRUE(fake_.sent.empty());
}

TEST_F(SendBackTest, WithoutASegmentationOnlyThePictureCanBeSent) {
  write_two_servers();
  open_dicom_with_mesh();
  bench().apply(DeleteMesh{scene().meshes[0].id});
  SendDialog* dialog = send_dialog();
  ASSERT_NE(dialog, nullptr);
  for (const char* box : {"send_labels", "send_contours", "send_report"}) {
    EXPECT_FALSE(dialog->findChild<QCheckBox*>(box)->isEnabled());
    EXPECT_EQ(dialog->findChild<QCheckBox*>(box)->toolTip(), "There is no segmentation yet");
  }
  EXPECT_FALSE(dialog->findChild<QPushButton*>("send_button")->isEnabled());
  click(*dialog, "send_view");
  click(*dialog, "send_button");
  ASSERT_TRUE(wait_until([&] { return fake_.sent.size() == 1; }));
  EXPECT_EQ(fake_.sent[0].sop_class, kCapture);
}

TEST_F(SendBackTest, TheArchiveOfTheImageIsPreselected) {
  write_two_servers();
  ArchiveDialog* find = find_dialog();
  QTest::keyClick(find->findChild<QComboBox*>("archive_server"), Qt::Key_Down);
  ASSERT_EQ(select_first_series(), find);
  click(*find, "archive_fetch");
  ASSERT_TRUE(
      wait_until([this] { return bench().has_volume() && !window_->actions()[Act::Open]->toolTip().isEmpty(); }));
  SendDialog* dialog = send_dialog();
  ASSERT_NE(dialog, nullptr);
  EXPECT_EQ(dialog->findChild<QComboBox*>("send_server")->currentIndex(), 1);
}

TEST_F(SendBackTest, WithoutAnArchiveARemedyIsShown) {
  open_dicom_with_mesh();
  SendDialog* dialog = send_dialog();
  ASSERT_NE(dialog, nullptr);
  auto* send = dialog->findChild<QPushButton*>("send_button");
  EXPECT_FALSE(send->isEnabled());
  EXPECT_EQ(send->toolTip(), "Add an archive first: File > Archive");
}

TEST_F(SendBackTest, AFaultIsOneLineAndARepeatedTransferReplacesItsFiles) {
  write_two_servers();
  open_dicom_with_mesh();
  SendDialog* dialog = send_dialog();
  ASSERT_NE(dialog, nullptr);
  const char* fault =
      "the archive one: the connection ended while it was sent to; try again (1 of 3 instances were stored)";
  fake_.fault = fault;
  click(*dialog, "send_button");
  ASSERT_TRUE(wait_until([&] { return !dialog->task().busy(); }));
  EXPECT_EQ(dialog->task().text(), QString(fault));
  EXPECT_TRUE(dialog->isVisible());
  const std::vector<DicomIdentity> first = fake_.sent;
  ASSERT_EQ(first.size(), 3u);
  fake_.fault.clear();
  fake_.blocked = true;
  click(*dialog, "send_button");
  auto* bar = dialog->findChild<QProgressBar*>();
  ASSERT_TRUE(wait_until([&] { return bar->maximum() == 12 && bar->value() == 3; }));
  fake_.blocked = false;
  ASSERT_TRUE(wait_until([this] { return window_->findChild<SendDialog*>() == nullptr; }));
  ASSERT_EQ(fake_.sent.size(), 3u);
  for (int n = 0; n < 3; ++n)
    EXPECT_EQ(fake_.sent[n].sop_instance, first[n].sop_instance) << "it replaces the file in the archive";
  EXPECT_TRUE(cached().empty());
}

TEST_F(SendBackTest, SendingIsCancelledByTheButtonOrByEsc) {
  write_two_servers();
  open_dicom_with_mesh();
  SendDialog* dialog = send_dialog();
  ASSERT_NE(dialog, nullptr);
  fake_.blocked = true;
  click(*dialog, "send_button");
  ASSERT_TRUE(wait_until([&] { return fake_.waiting == 1; }));
  EXPECT_EQ(cached().size(), 1u) << "files being sent";
  click(*dialog, "task_cancel");
  ASSERT_TRUE(wait_until([&] { return fake_.waiting == 0 && cached().empty(); }));
  EXPECT_TRUE(dialog->task().text().startsWith("Cancelled")) << dialog->task().text().toStdString();
  click(*dialog, "send_button");
  ASSERT_TRUE(wait_until([&] { return fake_.waiting == 1; }));
  QTest::keyClick(dialog, Qt::Key_Escape);
  EXPECT_TRUE(dialog->isVisible());
  ASSERT_TRUE(wait_until([&] { return fake_.waiting == 0 && cached().empty(); }));
  QTest::keyClick(dialog, Qt::Key_Escape);
  EXPECT_TRUE(wait_until([this] { return window_->findChild<SendDialog*>() == nullptr; }));
}

TEST_F(SendBackTest, AMissingImageFileIsReported) {
  write_two_servers();
  open_dicom_with_mesh();
  std::filesystem::remove_all(place("image"));
  SendDialog* dialog = send_dialog();
  ASSERT_NE(dialog, nullptr);
  click(*dialog, "send_button");
  ASSERT_TRUE(wait_until([&] { return !dialog->task().busy(); }));
  EXPECT_TRUE(dialog->task().text().contains("image")) << dialog->task().text().toStdString();
  EXPECT_FALSE(dialog->task().text().contains('\n'));
  EXPECT_TRUE(fake_.sent.empty());
  dialog->reject();
  EXPECT_TRUE(wait_until([this] { return cached().empty(); }));
}

}  // namespace
}  // namespace simplexseg
