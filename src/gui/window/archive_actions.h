// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QImage>
#include <QObject>
#include <QPointer>

#include "gui/window/archive/archive_task.h"

class QWidget;

namespace simplexseg {

class ActionTable;
class ArchiveDialog;
class BackgroundJob;
class FileActions;
class SendDialog;
class Workbench;

/// Actions that fetch from and send to an archive (PACS), each with its dialog.
class ArchiveActions : public QObject {
  Q_OBJECT
 public:
  /// `loading`: background job of FileActions. `picture`: returns a picture of the views, to be sent.
  ArchiveActions(Workbench& workbench, BackgroundJob& loading, FileActions& files, ActionTable& actions,
                 std::function<QImage()> picture, QWidget& window);
  ~ArchiveActions() override;

  /// Replaces the function that opens archives; for tests.
  void set_opener(ArchiveOpener open) { open_ = std::move(open); }
  /// Shows the search dialog with its last results. A fetched series is opened like a folder.
  void find();
  void send_back();

 private:
  void enable_actions();
  void open_fetched(const QString& folder);

  Workbench& workbench_;
  BackgroundJob& loading_;
  FileActions& files_;
  ActionTable& actions_;
  std::function<QImage()> picture_;
  QWidget& window_;
  ArchiveOpener open_ = open_archive;
  BackgroundJob *finding_, *sending_;  ///< outlive the dialogs
  QPointer<ArchiveDialog> find_;       ///< created on first use
  QPointer<SendDialog> send_;          ///< null unless open
};

}  // namespace simplexseg
