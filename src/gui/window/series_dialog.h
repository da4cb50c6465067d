// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>

#include "io/dicom/dicom_series.h"

class QLabel;
class QPushButton;
class QSpinBox;
class QTreeWidget;

namespace simplexseg {

/// Lists the DICOM series found, each with a picture, patient, study, size and faults; the user chooses one.
class SeriesDialog : public QDialog {
  Q_OBJECT
 public:
  SeriesDialog(FoundSeries found, QWidget* parent);
  /// Selected series; null if there is none.
  const DicomSeries* chosen() const;
  /// Number of the chosen volume in a 4D series, from 1.
  int volume() const;

 private:
  void add(const DicomSeries& series);
  void refresh();

  FoundSeries found_;
  QTreeWidget* list_;
  QLabel* details_;
  QWidget* volume_row_;
  QSpinBox* volume_;
  QPushButton* open_;
};

}  // namespace simplexseg
