// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QImage>
#include <QObject>
#include <QPointer>

#include "gui/window/archive_task.h"

class QWidget;

namespace simplexseg {

class ActionTable;
class ArchiveDialog;
class BackgroundJob;
class FileActions;
class SendDialog;
class Workbench;

/// What goes to and comes from an archive (PACS), each with its dialog.
class ArchiveActions : public QObject {
  Q_OBJECT
 public:
  /// `loading`: what FileActions reads with. `picture`: of the views, to be sent.
  ArchiveActions(Workbench& workbench, BackgroundJob& loading, FileActions& files, ActionTable& actions,
                 std::function<QImage()> picture, QWidget& window);
  ~ArchiveActions() override;

  /// Other archives than those of the network, from now on.
  void set_opener(ArchiveOpener open) { open_ = std::move(open); }
  /// Shows the dialog, with what was found before; a series that it fetches is opened like any folder.
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
  QPointer<ArchiveDialog> find_;       ///< made when it is wanted first
  QPointer<SendDialog> send_;          ///< while it is open
};

}  // namespace simplexseg
