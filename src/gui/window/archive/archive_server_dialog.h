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

/// Form for the connection to an archive. Stores the name of the variable or file with the credentials, never the
/// credentials themselves.
class ArchiveServerDialog : public QDialog {
  Q_OBJECT
 public:
  /// `save` receives the entered archive and throws Error to refuse it; the dialog then shows the error and stays open.
  ArchiveServerDialog(const ArchiveServer& server, std::function<void(const ArchiveServer&)> save, QWidget* parent);

  /// Archive as entered now.
  ArchiveServer server() const;

 private:
  void refresh();
  /// Throws Error when no variable or file is entered for the credentials, or the variable is not a valid name.
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
