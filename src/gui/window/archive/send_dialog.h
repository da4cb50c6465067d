// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <QImage>
#include <vector>

#include "gui/window/archive/archive_task.h"

class QCheckBox;
class QComboBox;
class QLabel;
class QPushButton;

namespace simplexseg {

/// Sends labels, contours and a picture to an archive, as new series in the study of the DICOM image.
class SendDialog : public QDialog {
  Q_OBJECT
 public:
  /// `picture`: picture of the views, to be sent. `job`: see ArchiveTask.
  SendDialog(Workbench& workbench, const QImage& picture, std::vector<ArchiveServer> servers, BackgroundJob& job,
             const ArchiveOpener& open, QWidget* parent);

  ~SendDialog() override;

  const ArchiveTask& task() const { return *task_; }
  /// Cancels the running operation; closes the dialog if there is none.
  void reject() override;

 private:
  struct OutgoingFiles;
  void refresh();
  void send();

  Workbench& workbench_;
  QImage picture_;
  std::vector<ArchiveServer> servers_;
  std::shared_ptr<OutgoingFiles> outgoing_;  ///< null before the first transfer and after a cancellation
  QComboBox* server_;
  QCheckBox *labels_, *contours_, *view_;
  ArchiveTask* task_;
  QPushButton* send_;
};

}  // namespace simplexseg
