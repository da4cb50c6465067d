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
class QPushButton;
class QSpinBox;

namespace simplexseg {

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
  /// Throws Error if credentials are selected but no variable or file is entered, or if the text entered for the
  /// variable contains characters that are invalid in a name.
  void require_named_credentials() const;
  void try_to_save();

  std::function<void(const ArchiveServer&)> save_;
  QFormLayout* form_;
  std::vector<QWidget*> web_rows_, dimse_rows_;  ///< rows shown for one protocol only
  QWidget* where_;                               ///< row of credentials_
  QPushButton* choose_;                          ///< opens a file dialog for credentials_
  QLineEdit *name_, *url_, *ca_file_, *credentials_, *host_, *called_, *calling_;
  QComboBox *protocol_, *kind_;
  QSpinBox *port_, *timeout_;
  QLabel* refusal_;
};

}  // namespace simplexseg
