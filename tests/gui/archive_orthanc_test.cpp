// SPDX-License-Identifier: Apache-2.0
// Window with a real archive (Debian's Orthanc on the loopback interface): fetch and send by mouse and keyboard.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <QComboBox>
#include <QFileInfo>
#include <QLineEdit>
#include <QProcess>
#include <QSpinBox>
#include <algorithm>
#include <fstream>
#include <thread>

#include "../io/dicom_slices.h"
#include "archive_fixture.h"
#include "gui/window/archive/archive_server_dialog.h"
#include "gui/window/message_bar.h"
#include "gui/workbench/background_job.h"
#include "io/labels/labels_io.h"
#include "session/label_map.h"

namespace simplexseg {
namespace {

constexpr const char* kOrthanc = "/usr/sbin/Orthanc";
constexpr const char* kDicomWeb = "/usr/share/orthanc/plugins/libOrthancDicomWeb.so";
constexpr const char* kStudy = "1.2.826.0.1.3680043.9.7.20";

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
  return address;
}

/// Returns an unused port.
int free_port() {
  const int probe = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address = loopback(0);
  socklen_t length = sizeof address;
  bind(probe, reinterpret_cast<sockaddr*>(&address), length);
  getsockname(probe, reinterpret_cast<sockaddr*>(&address), &length);
  close(probe);
  return ntohs(address.sin_port);
}

bool listens(int port) {
  const int probe = socket(AF_INET, SOCK_STREAM, 0);
  const sockaddr_in address = loopback(port);
  const bool taken = connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  close(probe);
  return taken;
}

/// Orthanc process with a separate store; killed by the destructor.
class Orthanc {
 public:
  const int web_port = free_port(), dicom_port = free_port();

  explicit Orthanc(const QString& folder) {
    const QString settings = folder + "/orthanc.json", store = folder + "/store";
    std::ofstream(settings.toStdString())
        << "{\"StorageDirectory\": \"" << store.toStdString() << "\", \"IndexDirectory\": \"" << store.toStdString()
        << "\", \"Plugins\": [\"" << kDicomWeb << R"("], "DicomWeb": {"Enable": true, "Root": "/dicom-web/"},)"
        << "\"HttpPort\": " << web_port << ", \"DicomPort\": " << dicom_port << R"(, "DicomAet": "ORTHANC",
        "DicomAlwaysAllowFind": true, "DicomAlwaysAllowGet": true, "DicomAlwaysAllowStore": true,
        "RemoteAccessAllowed": false, "AuthenticationEnabled": false, "HttpThreadsCount": 4})";
    process_.setStandardOutputFile(QProcess::nullDevice());
    process_.setStandardErrorFile(QProcess::nullDevice());
    process_.start(kOrthanc, {settings});
  }
  ~Orthanc() {
    process_.kill();
    process_.waitForFinished();
  }
  bool wait_until_ready() const {
    for (int n = 0; n < 600; ++n) {
      if (listens(web_port) && listens(dicom_port)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
  }
  std::string web() const { return "http://127.0.0.1:" + std::to_string(web_port) + "/dicom-web"; }

 private:
  QProcess process_;
};

/// Parameter: true for DICOMweb, false for DIMSE.
class ArchiveOrthancTest : public ArchiveFixture, public ::testing::WithParamInterface<bool> {
 protected:
  void SetUp() override {
    if (!QFileInfo::exists(kOrthanc) || !QFileInfo::exists(kDicomWeb))
      GTEST_SKIP() << "install orthanc and orthanc-dicomweb";
    ArchiveFixture::SetUp();
    if (IsSkipped()) return;
    window_->archive().set_opener(open_archive);
    orthanc_ = std::make_unique<Orthanc>(folder_.path());
    ASSERT_TRUE(orthanc_->wait_until_ready());
    test::write_series(place("sent"), {.columns = 48, .rows = 40, .study = kStudy}, 14);
    std::vector<std::filesystem::path> files;
    for (const auto& file : std::filesystem::directory_iterator(place("sent"))) files.push_back(file.path());
    ASSERT_EQ(open_archive(archive_server_at(orthanc_->web()))->send(files).stored, 14);
  }
  void TearDown() override {
    orthanc_.reset();
    ArchiveFixture::TearDown();
  }

  /// Adds Orthanc with the fields of the dialog.
  void add_server(ArchiveDialog& dialog) {
    click(dialog, "archive_add");
    auto* entry = dialog.findChild<ArchiveServerDialog*>();
    ASSERT_NE(entry, nullptr);
    const auto fill = [entry](const char* name, const QString& text) {
      for (QWidget* field : entry->findChildren<QWidget*>()) {
        if (field->accessibleName() != name) continue;
        if (auto* number = qobject_cast<QSpinBox*>(field)) number->selectAll();
        type(*field, text);
      }
    };
    fill("Name", "orthanc");
    if (GetParam()) {
      fill("Address", QString::fromStdString(orthanc_->web()));
    } else {
      QTest::keyClick(entry->findChild<QComboBox*>(), Qt::Key_Down);
      fill("Host", "127.0.0.1");
      fill("Port", QString::number(orthanc_->dicom_port));
      fill("AE title of the archive", "ORTHANC");
    }
    QTest::keyClick(entry->findChild<QLineEdit*>(), Qt::Key_Return);
    ASSERT_TRUE(wait_until([&] { return read_archive_servers().size() == 1; }));
  }

  std::unique_ptr<Orthanc> orthanc_;
};

TEST_P(ArchiveOrthancTest, ASeriesIsFetchedSegmentedAndSentBack) {
  ArchiveDialog* find = find_dialog();
  ASSERT_NE(find, nullptr);
  add_server(*find);
  click(*find, "archive_test");
  ASSERT_TRUE(wait_until([&] { return find->task().text() == "orthanc responds"; }))
      << find->task().text().toStdString();
  click(*find, "archive_search");
  QTreeWidget& tree = results(*find);
  // The series of a single study are listed at once.
  ASSERT_TRUE(wait_until([&] { return tree.topLevelItemCount() == 1 && tree.topLevelItem(0)->childCount() == 1; }))
      << find->task().text().toStdString();
  EXPECT_EQ(tree.topLevelItem(0)->text(0), "Doe, Jane");
  EXPECT_EQ(tree.topLevelItem(0)->text(2), "2024-05-31");
  QTreeWidgetItem* series = tree.topLevelItem(0)->child(0);
  EXPECT_EQ(series->text(3), "CT");
  EXPECT_EQ(series->text(6), "14");
  QTest::mouseClick(tree.viewport(), Qt::LeftButton, {}, tree.visualItemRect(series).center());
  ASSERT_TRUE(wait_until([&] { return !find->task().busy(); }));
  click(*find, "archive_fetch");
  ASSERT_TRUE(wait_until([this] { return bench().has_volume() && !window_->job().busy(); }))
      << find->task().text().toStdString();
  EXPECT_EQ(bench().session().volume().geometry().size, (std::array<int, 3>{48, 40, 14}));
  EXPECT_EQ(bench().session().volume().value(7, 3, 5), 105 + 30 + 7);

  // Seeds by mouse, and runs some steps.
  QTest::keyClick(window_->windowHandle(), Qt::Key_4);
  window_->actions()[Act::ToolSeed]->trigger();
  const QPointF middle = QRectF(axial().rect()).center();
  drag(axial(), middle, middle + QPointF(50, 0));
  ASSERT_EQ(scene().meshes.size(), 1u);
  bench().pause();
  bench().advance_steps(5);

  SendDialog* send = send_dialog();
  ASSERT_NE(send, nullptr);
  click(*send, "send_button");
  ASSERT_TRUE(wait_until([this] { return window_->findChild<SendDialog*>() == nullptr; }))
      << send->task().text().toStdString();
  EXPECT_TRUE(window_->messages().text().startsWith("Sent 3 series to orthanc"))
      << window_->messages().text().toStdString();

  // The archive now contains the three new series.
  const std::unique_ptr<Archive> archive = open_archive(archive_server_at(orthanc_->web()));
  const ArchiveCache cache(place("check"));
  std::vector<std::string> kinds;
  std::filesystem::path labels;
  for (const ArchiveSeries& one : archive->find_series(kStudy)) {
    kinds.push_back(one.modality);
    if (one.modality == "SEG") labels = archive->fetch(kStudy, one.uid, cache);
  }
  std::sort(kinds.begin(), kinds.end());
  EXPECT_EQ(kinds, (std::vector<std::string>{"CT", "OT", "RTSTRUCT", "SEG"}));
  ASSERT_FALSE(labels.empty());
  std::vector<std::string> warnings;
  const VolumeGeometry geometry = bench().session().volume().geometry();
  const Volume received =
      load_labels_onto(std::filesystem::directory_iterator(labels)->path(), geometry, "the image", warnings);
  const LabelMap sent = make_label_map(scene(), geometry);
  int inside = 0, different = 0;
  for (int k = 0; k < geometry.size[2]; ++k)
    for (int j = 0; j < geometry.size[1]; ++j)
      for (int i = 0; i < geometry.size[0]; ++i) {
        inside += sent.labels.value(i, j, k) > 0;
        different += (sent.labels.value(i, j, k) > 0) != (received.value(i, j, k) > 0);
      }
  EXPECT_GT(inside, 100);
  EXPECT_EQ(different, 0);
}

TEST_P(ArchiveOrthancTest, AnUnreachableArchiveIsOneLine) {
  ArchiveDialog* find = find_dialog();
  ASSERT_NE(find, nullptr);
  add_server(*find);
  orthanc_.reset();
  click(*find, "archive_search");
  ASSERT_TRUE(wait_until([&] { return !find->task().busy(); }));
  EXPECT_TRUE(find->task().text().contains("refused the connection")) << find->task().text().toStdString();
  EXPECT_FALSE(find->task().text().contains('\n'));
}

INSTANTIATE_TEST_SUITE_P(Protocols, ArchiveOrthancTest, ::testing::Bool(),
                         [](const auto& info) { return info.param ? "DicomWeb" : "Dimse"; });

}  // namespace
}  // namespace simplexseg
