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
#include "gui/window/archive/archive_dialog.h"
#include "gui/window/archive/send_dialog.h"
#include "gui/window/archive_actions.h"
#include "io/dicom/dicom_identity.h"
#include "window_fixture.h"

namespace simplexseg {

/// Fake archive without a network, used by the threads of the dialogs.
struct FakeArchive {
  static constexpr const char* kStudy = "1.2.3";
  static constexpr const char* kSeries = "1.2.3.1";

  FakeArchive();
  std::unique_ptr<Archive> open(const ArchiveServer& server);

  // Written while no operation is running.
  std::vector<ArchiveStudy> studies;
  std::vector<ArchiveSeries> series;
  std::string fault;  ///< error that all calls throw; empty: none
  std::vector<std::string> warnings;

  std::atomic<bool> blocked{false};  ///< calls report "3 of 12" and wait until cancelled or unblocked
  std::atomic<int> waiting{0};       ///< number of waiting calls

  // Written by the thread, read after it has ended.
  ArchiveQuery last_query;
  std::string server;
  std::vector<DicomIdentity> sent;  ///< by the last call, even if it failed
  std::vector<std::string> sent_bytes;
};

/// Window with a fake archive and with separate settings and cache.
class ArchiveFixture : public WindowTest {
 protected:
  void SetUp() override;
  void TearDown() override;

  /// Writes a list of two archives: "one", by DICOMweb, and "two", by DIMSE.
  static void write_two_servers();
  std::filesystem::path place(const char* name) const { return folder_.filePath(name).toStdString(); }
  /// Folders in the cache, including those of incomplete series.
  std::vector<std::string> cached() const;

  ArchiveDialog* find_dialog();
  SendDialog* send_dialog();
  /// Simulates a mouse click on a button, or typing into a field.
  static void click(QWidget& dialog, const char* button);
  static void type(QWidget& field, const QString& text);
  static QTreeWidget& results(const ArchiveDialog& dialog);
  /// Opens the dialog, searches without restriction, expands the first study and selects its first series.
  ArchiveDialog* select_first_series();
  /// Opens a DICOM image of 24 x 20 x 10 voxels in the study 1.2.3, with a mesh at its centre.
  void open_dicom_with_mesh();

  FakeArchive fake_;

 private:
  std::map<std::string, QByteArray> environment_;
};

}  // namespace simplexseg
