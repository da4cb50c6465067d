// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <QImage>
#include <vector>

#include "gui/window/archive_task.h"

class QCheckBox;
class QComboBox;
class QLabel;
class QPushButton;

namespace simplexseg {

/// Sends what was made of a DICOM image into the study that the image is of: labels, contours, a picture.
class SendDialog : public QDialog {
  Q_OBJECT
 public:
  /// `picture`: of the views. `job`: as ArchiveTask takes it.
  SendDialog(Workbench& workbench, const QImage& picture, std::vector<ArchiveServer> servers, BackgroundJob& job,
             const ArchiveOpener& open, QWidget* parent);

  ~SendDialog() override;

  const ArchiveTask& task() const { return *task_; }
  /// The first time calls off what is under way.
  void reject() override;

 private:
  struct Parcel;
  void refresh();
  void send();

  Workbench& workbench_;
  QImage picture_;
  std::vector<ArchiveServer> servers_;
  std::shared_ptr<Parcel> parcel_;  ///< none before the first time
  QComboBox* server_;
  QCheckBox *labels_, *contours_, *view_;
  ArchiveTask* task_;
  QPushButton* send_;
};

}  // namespace simplexseg
