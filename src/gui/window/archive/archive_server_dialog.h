// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <functional>
#include <vector>

#include "archive/server.h"

class QComboBox;
class QFormLayout;
class QLabel;
class QLineEdit;
class QSpinBox;

namespace simplexseg {

class ConnectionFields;

/// Dialog for the connection settings of an archive. Stores only the name of the environment variable, or the path of
/// the file, that contains the credentials.
class ArchiveServerDialog : public QDialog {
  Q_OBJECT
 public:
  /// `save` stores the entered settings. If it throws Error, the dialog shows the error and stays open.
  ArchiveServerDialog(const ArchiveServer& server, std::function<void(const ArchiveServer&)> save, QWidget* parent);

  /// Settings as currently entered.
  ArchiveServer server() const;

 private:
  void refresh();
  void fit_height();
  void try_to_save();

  std::function<void(const ArchiveServer&)> save_;
  QFormLayout* form_;
  std::vector<QWidget*> dimse_rows_;  ///< rows shown for DIMSE only
  ConnectionFields* connection_;      ///< rows shown for DICOMweb only
  QLineEdit *name_, *url_, *host_, *called_, *calling_;
  QComboBox* protocol_;
  QSpinBox *port_, *timeout_;
  QLabel* refusal_;
};

}  // namespace simplexseg
