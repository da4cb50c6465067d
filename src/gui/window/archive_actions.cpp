// SPDX-License-Identifier: Apache-2.0
#include "gui/window/archive_actions.h"

#include <QAction>
#include <QWidget>

#include "gui/input/action_table.h"
#include "gui/look/widgets.h"
#include "gui/window/archive/archive_dialog.h"
#include "gui/window/archive/send_dialog.h"
#include "gui/window/file_actions.h"
#include "gui/workbench/background_job.h"

namespace simplexseg {

ArchiveActions::ArchiveActions(Workbench& workbench, BackgroundJob& loading, FileActions& files, ActionTable& actions,
                               std::function<QImage()> picture, QWidget& window)
    : QObject(&window),
      workbench_(workbench),
      loading_(loading),
      files_(files),
      actions_(actions),
      picture_(std::move(picture)),
      window_(window),
      finding_(new BackgroundJob(this)),
      sending_(new BackgroundJob(this)) {
  actions.on(Act::Archive, [this] { find(); });
  actions.on(Act::SendBack, [this] { send_back(); });
  connect(&workbench_, &Workbench::volume_changed, this, &ArchiveActions::enable_actions);
  connect(&files_, &FileActions::name_changed, this, &ArchiveActions::enable_actions);
  connect(&loading_, &BackgroundJob::busy_changed, this, &ArchiveActions::enable_actions);
  enable_actions();
}

ArchiveActions::~ArchiveActions() {
  delete find_;
  delete send_;
}

void ArchiveActions::enable_actions() {
  const bool volume = workbench_.has_volume(), dicom = volume && files_.is_dicom();
  set_enabled(actions_[Act::SendBack], dicom && !loading_.busy(),
              dicom    ? tr("Wait until loading or saving has finished")
              : volume ? tr("The image is not DICOM, so there is no study to send to")
                       : tr("Open a DICOM image first"));
}

void ArchiveActions::find() {
  if (!find_) {
    find_ = new ArchiveDialog(*finding_, open_, &window_);
    connect(find_, &ArchiveDialog::fetched, this, &ArchiveActions::open_fetched);
  }
  find_->read_servers();
  find_->show();
  find_->raise();
  find_->activateWindow();
}

void ArchiveActions::open_fetched(const QString& folder) {
  find_->accept();
  if (loading_.busy())
    workbench_.notify(
        Severity::Warning,
        tr("The series was fetched, but another file is being loaded or saved. Open the series again later."));
  else
    files_.open(folder);
}

void ArchiveActions::send_back() {
  std::vector<ArchiveServer> servers;
  try {
    servers = read_archive_servers();
  } catch (const std::exception& error) {
    workbench_.notify(Severity::Failure, QString::fromUtf8(error.what()));
    return;
  }
  send_ = new SendDialog(workbench_, picture_(), std::move(servers), *sending_, open_, &window_);
  send_->setAttribute(Qt::WA_DeleteOnClose);
  send_->open();
}

}  // namespace simplexseg
