// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <QImage>
#include <string>
#include <vector>

#include "gui/window/archive/archive_task.h"

class QCheckBox;
class QComboBox;
class QLabel;
class QPushButton;
class QVBoxLayout;

namespace simplexseg {

/// Sends labels, contours, a report and a picture to an archive, as new series in the study of the DICOM image.
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
  void build_items(QVBoxLayout& column);
  void refresh();
  void send();
  /// Names of the files that are chosen.
  std::vector<std::string> chosen() const;

  Workbench& workbench_;
  QImage picture_;
  std::vector<ArchiveServer> servers_;
  std::shared_ptr<OutgoingFiles> outgoing_;  ///< null before the first transfer and after a cancellation
  QComboBox *server_, *encoding_;
  QCheckBox *labels_, *contours_, *report_, *view_;
  ArchiveTask* task_;
  QPushButton* send_;
};

}  // namespace simplexseg
