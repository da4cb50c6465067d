// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>

#include "io/model/train_from_table.h"

class QCheckBox;
class QLabel;
class QLineEdit;
class QProgressBar;
class QPushButton;
class QTableWidget;

namespace simplexseg {

class BackgroundJob;
class Workbench;

/// Trains the model of an organ from accepted cases (docs/models.md), in the background. The cases are rows of tables,
/// pairs of an image and labels, or the locked active segmentation.
class TrainDialog : public QDialog {
  Q_OBJECT
 public:
  TrainDialog(Workbench& workbench, QWidget* parent);

  /// Adds the cases of a table (CSV); shows the reason if it cannot be read.
  void open_table(const QString& path);
  /// Adds a case. `label`: value or name; "": all voxels that are not 0.
  void add_case(const QString& image, const QString& labels, const QString& label = {}, bool mirror = false);
  /// Writes the labels of the active segmentation and adds its case; shows the reason if that fails.
  void add_active(const QString& labels);
  /// Adds the cases to a model; empty: trains a new one.
  void set_base(const QString& model);
  /// Trains in the background and writes the model.
  void train(const QString& model);
  bool busy() const;

 signals:
  void finished_training(const QString& model);

 private:
  std::vector<TableCase> cases() const;
  void ask_table();
  void ask_case();
  void ask_active();
  void ask_base();
  void ask_model();
  void finish(const QString& model, const TrainedTable& trained);
  void refresh();
  void show_message(const QString& message, bool is_warning = false);

  Workbench& workbench_;
  QTableWidget* list_;
  QLineEdit *name_, *modality_;
  QLabel *base_, *message_;
  QCheckBox* use_;
  QProgressBar* progress_;
  QPushButton *remove_, *active_, *train_, *cancel_;
  QString base_path_;
  BackgroundJob* job_;
};

}  // namespace simplexseg
