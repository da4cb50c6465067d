// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>

#include "io/dicom_series.h"

class QLabel;
class QPushButton;
class QSpinBox;
class QTreeWidget;

namespace simplexseg {

/// The series that were found, each with a picture, what it is of, its size, and what is wrong with it; one is chosen.
class SeriesDialog : public QDialog {
  Q_OBJECT
 public:
  SeriesDialog(FoundSeries found, QWidget* parent);
  /// Null where no series is marked.
  const DicomSeries* chosen() const;
  /// Which of its volumes, from 1.
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
