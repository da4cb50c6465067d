// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QPushButton>
#include <QTest>
#include <QTreeWidget>
#include <atomic>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "archive/archive.h"
#include "gui/window/archive_actions.h"
#include "gui/window/archive_dialog.h"
#include "gui/window/send_dialog.h"
#include "io/dicom_identity.h"
#include "window_fixture.h"

namespace simplexseg {

/// An archive without a network, as every dialog's thread sees it.
struct FakeArchive {
  static constexpr const char* kStudy = "1.2.3";
  static constexpr const char* kSeries = "1.2.3.1";

  FakeArchive();
  std::unique_ptr<Archive> open(const ArchiveServer& server);

  // Written while nothing is under way.
  std::vector<ArchiveStudy> studies;
  std::vector<ArchiveSeries> series;
  std::string fault;  ///< what all calls throw; empty: nothing
  std::vector<std::string> warnings;

  std::atomic<bool> holds{false};  ///< calls tell "3 of 12" and wait until they are called off, or this is false
  std::atomic<int> waiting{0};     ///< calls that do

  // Written by the thread, read when it has ended.
  ArchiveQuery asked;
  std::string server;
  std::vector<DicomIdentity> sent;  ///< the last time, also where that failed
  std::vector<std::string> sent_bytes;
};

/// A window with a fake archive, and settings and cache of its own.
class ArchiveFixture : public WindowTest {
 protected:
  void SetUp() override;
  void TearDown() override;

  /// Writes the file of archives: "one", by DICOMweb, and "two", by DIMSE.
  static void know_two_servers();
  std::filesystem::path place(const char* name) const { return folder_.filePath(name).toStdString(); }
  /// What lies in the cache, whole series and whatever else; files not counted.
  std::vector<std::string> cached() const;

  ArchiveDialog* find_dialog();
  SendDialog* send_dialog();
  /// Real clicks and keys.
  static void click(QWidget& dialog, const char* button);
  static void type(QWidget& field, const QString& text);
  static QTreeWidget& results(const ArchiveDialog& dialog);
  /// Opens the dialog, searches for everything, unfolds the first study and marks its first series.
  ArchiveDialog* mark_first_series();
  /// Opens a DICOM image of 24 x 20 x 10 voxels, of the study 1.2.3, with a mesh in its middle.
  void open_dicom_with_mesh();

  FakeArchive fake_;

 private:
  std::map<std::string, QByteArray> environment_;
};

}  // namespace simplexseg
